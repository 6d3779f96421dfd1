typedef struct { double of[6]; } networks_results;

/* z/sqrt(1 + z^2) of STEP z; the root in single precision and one Newton step, which is exact to 1e-14 */
static void squash(double *z)
{
    for (int k = 0; k < WIDTH; k++) {
        const double v = 1.0 + square(STEP * z[k]), y = 1.0f / sqrtf((float)v);
        z[k] *= STEP * y * (1.5 - 0.5 * v * y * y);
    }
}

CLONES static networks_results networks(const double logarithms[])
{
    networks_results r = {{1.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
    double x[SIZE], beyond[SIZE], one[WIDTH], two[WIDTH], out[2 * MEMBERS];
    for (int i = 0; i < SIZE; i++) {
        const double low = networks_scales[2][i], high = networks_scales[3][i], reach = FADE * (high - low);
        const double at = (at_most(at_least(logarithms[i], -1e3), 1e3) - networks_scales[0][i]) / networks_scales[1][i];
        beyond[i] = at_least(low - at, at - high) / reach;
        x[i] = at_most(at_least(at, low - reach), high + reach);
    }
    for (int i = 0; i < SIZE; i++) r.of[0] = at_most(r.of[0], 1.0 - beyond[i]);
    r.of[0] = at_least(r.of[0], 0.0);
    r.of[0] *= r.of[0] * (3.0 - 2.0 * r.of[0]);
    for (int k = 0; k < WIDTH; k++) one[k] = networks_first[SIZE][k];
    int i = 0; /* four rows at a time, as sums in memory take longer than products */
    for (; i + 3 < SIZE; i += 4)
        for (int k = 0; k < WIDTH; k++)
            one[k] += networks_first[i][k] * x[i] + networks_first[i + 1][k] * x[i + 1]
                + networks_first[i + 2][k] * x[i + 2] + networks_first[i + 3][k] * x[i + 3];
    for (; i < SIZE; i++) for (int k = 0; k < WIDTH; k++) one[k] += networks_first[i][k] * x[i];
    squash(one);
    for (int k = 0; k < WIDTH; k++) two[k] = networks_second[UNITS][k];
    for (int m = 0; m < WIDTH; m += UNITS) {
        for (i = 0; i + 3 < UNITS; i += 4)
            for (int k = m; k < m + UNITS; k++)
                two[k] += networks_second[i][k] * one[m + i] + networks_second[i + 1][k] * one[m + i + 1]
                    + networks_second[i + 2][k] * one[m + i + 2] + networks_second[i + 3][k] * one[m + i + 3];
        for (; i < UNITS; i++) for (int k = m; k < m + UNITS; k++) two[k] += networks_second[i][k] * one[m + i];
    }
    squash(two);
    for (int j = 0; j < 2 * MEMBERS; j++) out[j] = networks_last[UNITS][j];
    for (int i = 0; i < UNITS; i++)
        for (int j = 0; j < 2 * MEMBERS; j++) out[j] += networks_last[i][j] * two[j / 2 * UNITS + i];
    for (int j = 0; j < 2 * MEMBERS; j++) r.of[1 + j % 2] += (out[j] *= STEP) / MEMBERS;
    for (int m = 0; m < MEMBERS; m++) {
        const double a = out[2 * m] - r.of[1], b = out[2 * m + 1] - r.of[2], squares[3] = {a * a, a * b, b * b};
        for (int i = 0; i < 3; i++) r.of[3 + i] += squares[i] / MEMBERS;
    }
    return r;
}
