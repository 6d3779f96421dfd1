function r = guard(x)
  [scales, whitening, cases, limits] = guard_data();
  [x, shape] = rows(x);
  x = x - scales(:, 1);
  u = x ./ scales(:, 2);
  z = whitening' * x;
  r = {Inf, sqrt(sum(z .^ 2, 1)), Inf};
  for j = 1:CASES
    r{1} = min(r{1}, sum((z - STEP * cases(j, :)') .^ 2, 1));
  end
  r{1} = sqrt(r{1});
  for row = limits
    total = u(row(1) + 1, :) + u(row(2) + 1, :); apart = u(row(1) + 1, :) - u(row(2) + 1, :);
    r{3} = min(min(r{3}, total - STEP * row(3)), STEP * row(4) - total);
    r{3} = min(min(r{3}, apart - STEP * row(5)), STEP * row(6) - apart);
  end
  r = cellfun(@(v) reshape(v, shape), r, 'UniformOutput', false);
end
