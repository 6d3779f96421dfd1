  pure function guard(logarithms) result(r)
    real(dp), intent(in) :: logarithms(:)
    real(dp) :: r(3), c(SIZE), u(SIZE), z(SIZE), total, apart, ends(4)
    integer :: j
    c = min(max(logarithms, -1e3_dp), 1e3_dp) - guard_scales(:, 1)
    u = c / guard_scales(:, 2)
    z = matmul(c, guard_whitening)
    r(2:) = [sqrt(sum(z ** 2)), huge(total)]
    r(1) = sqrt(minval([(sum((z - STEP_dp * guard_cases(j, :)) ** 2), j = 1, CASES)]))
    do j = 1, PAIRS
      ends = STEP_dp * guard_limits(3:, j)
      total = u(1 + guard_limits(1, j)) + u(1 + guard_limits(2, j))
      apart = u(1 + guard_limits(1, j)) - u(1 + guard_limits(2, j))
      r(3) = min(r(3), total - ends(1), ends(2) - total, apart - ends(3), ends(4) - apart)
    end do
  end function guard
