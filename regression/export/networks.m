function r = networks(x)
  [scales, first, second, last] = networks_data();
  [x, shape] = rows(x);
  low = scales(:, 3); high = scales(:, 4); reach = FADE * (high - low);
  x = (x - scales(:, 1)) ./ scales(:, 2);
  fading = min(max(1 - max(max(low - x, x - high) ./ reach, [], 1), 0), 1);
  one = squashed(layer(first, min(max(x, low - reach), high + reach)));
  out = zeros(2, size(x, 2), MEMBERS);
  for m = 1:MEMBERS
    own = UNITS * (m - 1) + (1:UNITS);
    out(:, :, m) = STEP * layer(last(2 * m - 1:2 * m, :), squashed(layer(second(own, :), one(own, :))));
  end
  centre = mean(out, 3);
  a = out(1, :, :) - centre(1, :); b = out(2, :, :) - centre(2, :);
  r = {fading .^ 2 .* (3 - 2 * fading), centre(1, :), centre(2, :), mean(a .^ 2, 3), mean(a .* b, 3), mean(b .^ 2, 3)};
  r = cellfun(@(v) reshape(v, shape), r, 'UniformOutput', false);
end

function z = layer(weights, x)
  z = weights(:, 1:end - 1) * x + weights(:, end);
end

function s = squashed(z)
  s = STEP * z ./ sqrt(1 + (STEP * z) .^ 2);
end
