  pure function networks(logarithms) result(r)
    real(dp), intent(in) :: logarithms(:)
    real(dp) :: r(6), out(2, MEMBERS), x(SIZE), reach(SIZE), one(UNITS), two(UNITS)
    integer :: m
    reach = FADE_dp * (networks_scales(:, 4) - networks_scales(:, 3))
    x = (min(max(logarithms, -1e3_dp), 1e3_dp) - networks_scales(:, 1)) / networks_scales(:, 2)
    r(1) = 1.0_dp - maxval(max(networks_scales(:, 3) - x, x - networks_scales(:, 4)) / reach)
    r(1) = min(max(r(1), 0.0_dp), 1.0_dp)
    r(1) = r(1) * r(1) * (3.0_dp - 2.0_dp * r(1))
    x = min(max(x, networks_scales(:, 3) - reach), networks_scales(:, 4) + reach)
    do m = 1, MEMBERS
      one = layer(networks_weights(:FIRST, m), x, UNITS)
      one = one / sqrt(1.0_dp + one ** 2)
      two = layer(networks_weights(FIRST + 1:SECOND, m), one, UNITS)
      two = two / sqrt(1.0_dp + two ** 2)
      out(:, m) = layer(networks_weights(SECOND + 1:, m), two, 2)
    end do
    r(2:3) = sum(out, 2) / MEMBERS
    r(4) = sum((out(1, :) - r(2)) ** 2) / MEMBERS
    r(5) = sum((out(1, :) - r(2)) * (out(2, :) - r(3))) / MEMBERS
    r(6) = sum((out(2, :) - r(3)) ** 2) / MEMBERS
  end function networks

  pure function layer(weights, x, units) result(z)
    integer, intent(in) :: weights(:), units
    real(dp), intent(in) :: x(:)
    real(dp) :: z(units)
    integer :: i
    z = weights(units * size(x) + 1:)
    do i = 1, size(x)
      z = z + weights(units * (i - 1) + 1:units * i) * x(i)
    end do
    z = STEP_dp * z
  end function layer
