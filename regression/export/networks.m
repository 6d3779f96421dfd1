function r = networks(x)
  [scales, weights] = networks_data();
  [x, shape] = rows(x);
  low = scales(:, 3); high = scales(:, 4); reach = FADE * (high - low);
  x = (x - scales(:, 1)) ./ scales(:, 2);
  fading = min(max(1 - max(max(low - x, x - high) ./ reach, [], 1), 0), 1);
  x = min(max(x, low - reach), high + reach);
  out = zeros(2, size(x, 2), MEMBERS);
  for m = 1:MEMBERS
    w = STEP * weights(:, m);
    one = layer(w(1:FIRST), x, UNITS);
    two = layer(w(FIRST + 1:SECOND), one ./ sqrt(1 + one .^ 2), UNITS);
    out(:, :, m) = layer(w(SECOND + 1:end), two ./ sqrt(1 + two .^ 2), 2);
  end
  centre = mean(out, 3);
  a = out(1, :, :) - centre(1, :); b = out(2, :, :) - centre(2, :);
  r = {fading .^ 2 .* (3 - 2 * fading), centre(1, :), centre(2, :), mean(a .^ 2, 3), mean(a .* b, 3), mean(b .^ 2, 3)};
  r = cellfun(@(v) reshape(v, shape), r, 'UniformOutput', false);
end

function z = layer(weights, x, units)
  weights = reshape(weights, units, []);
  z = weights(:, 1:end - 1) * x + weights(:, end);
end
