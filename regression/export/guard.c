/* moves the least of each column of v to its first row, by halves */
INLINE void least(const int n, const int rows, double v[])
{
    for (int m = rows; m > 1; m -= m / 2)
        for (int j = 0; j < m / 2 * n; j++) v[j] = at_most(v[j], v[j + (m - m / 2) * n]);
}

INLINE void guard(const int n, const double *restrict logarithms, double *restrict of)
{
    double c[SIZE * BLOCK], u[SIZE * BLOCK], z[SIZE * BLOCK], squares[CASES * BLOCK], margins[PAIRS * BLOCK];
    EACH_POINT of[n + p] = 0.0;
    for (int i = 0; i < SIZE; i++) {
        EACH_POINT c[i * n + p] = at_most(at_least(logarithms[i * n + p], -1e3), 1e3) - guard_scales[0][i];
        EACH_POINT u[i * n + p] = c[i * n + p] / guard_scales[1][i];
        EACH_POINT z[i * n + p] = 0.0;
        for (int k = 0; k <= i; k++) EACH_POINT z[i * n + p] += guard_whitening[i][k] * c[k * n + p];
        EACH_POINT of[n + p] += z[i * n + p] * z[i * n + p];
    }
    for (int j = 0; j < CASES * n; j++) squares[j] = 0.0;
    for (int i = 0; i < SIZE; i++)
        for (int j = 0; j < CASES; j++) EACH_POINT squares[j * n + p] += square(z[i * n + p] - STEP * guard_cases[i][j]);
    for (int j = 0; j < PAIRS; j++) {
        const double *one = u + n * guard_limits[j][0], *other = u + n * guard_limits[j][1];
        const double low = STEP * guard_limits[j][2], high = STEP * guard_limits[j][3];
        const double lowest = STEP * guard_limits[j][4], highest = STEP * guard_limits[j][5];
        EACH_POINT {
            const double sum = one[p] + other[p], apart = one[p] - other[p];
            margins[j * n + p] = at_most(at_most(sum - low, high - sum), at_most(apart - lowest, highest - apart));
        }
    }
    least(n, CASES, squares);
    least(n, PAIRS, margins);
    EACH_POINT of[p] = sqrt(squares[p]);
    EACH_POINT of[n + p] = sqrt(of[n + p]);
    EACH_POINT of[2 * n + p] = margins[p];
}
