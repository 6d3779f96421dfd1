typedef struct { double of[3]; } guard_results;

CLONES static guard_results guard(const double logarithms[])
{
    guard_results r = {{INFINITY, 0.0, INFINITY}};
    double c[SIZE], u[SIZE], z[SIZE], squares[CASES];
    for (int i = 0; i < SIZE; i++) {
        c[i] = at_most(at_least(logarithms[i], -1e3), 1e3) - guard_scales[0][i];
        u[i] = c[i] / guard_scales[1][i];
        z[i] = 0.0;
        for (int k = 0; k <= i; k++) z[i] += guard_whitening[i][k] * c[k];
        r.of[1] += z[i] * z[i];
    }
    for (int j = 0; j < CASES; j++) squares[j] = 0.0;
    for (int i = 0; i < SIZE; i++) for (int j = 0; j < CASES; j++) squares[j] += square(z[i] - STEP * guard_cases[i][j]);
    for (int j = 0; j < CASES; j++) r.of[0] = at_most(r.of[0], squares[j]);
    for (int j = 0; j < PAIRS; j++) {
        const int *row = guard_limits[j];
        const double sum = u[row[0]] + u[row[1]], apart = u[row[0]] - u[row[1]];
        const double ends[4] = {sum - STEP * row[2], STEP * row[3] - sum, apart - STEP * row[4], STEP * row[5] - apart};
        for (int i = 0; i < 4; i++) r.of[2] = at_most(r.of[2], ends[i]);
    }
    r.of[0] = sqrt(r.of[0]);
    r.of[1] = sqrt(r.of[1]);
    return r;
}
