  pure function networks(logarithms) result(r)
    real(dp), intent(in) :: logarithms(:)
    real(dp) :: r(6), out(2, MEMBERS), x(SIZE), reach(SIZE), one(WIDTH), two(UNITS)
    integer :: m
    reach = FADE_dp * (networks_scales(:, 4) - networks_scales(:, 3))
    x = (min(max(logarithms, -1e3_dp), 1e3_dp) - networks_scales(:, 1)) / networks_scales(:, 2)
    r(1) = min(max(1.0_dp - maxval(max(networks_scales(:, 3) - x, x - networks_scales(:, 4)) / reach), 0.0_dp), 1.0_dp)
    r(1) = r(1) * r(1) * (3.0_dp - 2.0_dp * r(1))
    x = min(max(x, networks_scales(:, 3) - reach), networks_scales(:, 4) + reach)
    one = STEP_dp * (matmul(networks_first(:, :SIZE), x) + networks_first(:, SIZE + 1))
    one = one / sqrt(1.0_dp + one * one)
    do m = 1, MEMBERS
      associate (begin => UNITS * (m - 1) + 1, end => UNITS * m)
        two = STEP_dp * (matmul(networks_second(begin:end, :UNITS), one(begin:end)) + networks_second(begin:end, UNITS + 1))
        two = two / sqrt(1.0_dp + two * two)
      end associate
      out(:, m) = matmul(networks_last(2 * m - 1:2 * m, :UNITS), two) + networks_last(2 * m - 1:2 * m, UNITS + 1)
    end do
    out = STEP_dp * out
    r(2:3) = sum(out, 2) / MEMBERS
    r(4) = sum((out(1, :) - r(2)) ** 2) / MEMBERS
    r(5) = sum((out(1, :) - r(2)) * (out(2, :) - r(3))) / MEMBERS
    r(6) = sum((out(2, :) - r(3)) ** 2) / MEMBERS
  end function networks
