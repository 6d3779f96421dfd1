/* y = s(w x + b) of a layer with the biases after the rows of weights, s(z) = z/sqrt(1 + z^2) with z in units of STEP.
 * Four rows at a time spare sums in memory; the root in single precision with one Newton step is exact to 1e-14. */
INLINE void layer(const int n, const int rows, const int units, const double *weights, const double *restrict x,
                  double *restrict y)
{
    for (int k = 0; k < units; k++) EACH_POINT y[k * n + p] = weights[rows * WIDTH + k];
    int i = 0;
    for (const double *w = weights; i + 3 < rows; i += 4, w += 4 * WIDTH)
        for (int k = 0; k < units; k++)
            EACH_POINT y[k * n + p] = y[k * n + p] + w[k] * x[i * n + p] + w[k + WIDTH] * x[(i + 1) * n + p]
                + w[k + 2 * WIDTH] * x[(i + 2) * n + p] + w[k + 3 * WIDTH] * x[(i + 3) * n + p];
    for (; i < rows; i++)
        for (int k = 0; k < units; k++) EACH_POINT y[k * n + p] += weights[i * WIDTH + k] * x[i * n + p];
    for (int k = 0; k < units * n; k++) {
        const double v = 1.0 + square(STEP * y[k]), root = 1.0f / sqrtf((float)v);
        y[k] *= STEP * root * (1.5 - 0.5 * v * root * root);
    }
}

INLINE void networks(const int n, const double *restrict logarithms, double *restrict of)
{
    double x[SIZE * BLOCK], one[WIDTH * BLOCK], two[WIDTH * BLOCK], out[2 * MEMBERS * BLOCK];
    for (int i = 0; i < 6 * n; i++) of[i] = i < n ? 1.0 : 0.0;
    for (int i = 0; i < SIZE; i++) {
        const double low = networks_scales[2][i], high = networks_scales[3][i], reach = FADE * (high - low);
        EACH_POINT {
            const double z = at_most(at_least(logarithms[i * n + p], -1e3), 1e3);
            const double at = (z - networks_scales[0][i]) / networks_scales[1][i];
            of[p] = at_most(of[p], 1.0 - at_least(low - at, at - high) / reach);
            x[i * n + p] = at_most(at_least(at, low - reach), high + reach);
        }
    }
    EACH_POINT of[p] = square(at_least(of[p], 0.0)) * (3.0 - 2.0 * of[p]);
    layer(n, SIZE, WIDTH, networks_first[0], x, one);
    for (int m = 0; m < WIDTH; m += UNITS) layer(n, UNITS, UNITS, networks_second[0] + m, one + m * n, two + m * n);
    for (int j = 0; j < 2 * MEMBERS; j++) EACH_POINT out[j * n + p] = networks_last[UNITS][j];
    for (int i = 0; i < UNITS; i++)
        for (int j = 0; j < 2 * MEMBERS; j++)
            EACH_POINT out[j * n + p] += networks_last[i][j] * two[(j / 2 * UNITS + i) * n + p];
    for (int j = 0; j < 2 * MEMBERS; j++) EACH_POINT of[(1 + j % 2) * n + p] += (out[j * n + p] *= STEP) / MEMBERS;
    for (int m = 0; m < 2 * MEMBERS; m += 2) EACH_POINT {
        const double a = out[m * n + p] - of[n + p], b = out[(m + 1) * n + p] - of[2 * n + p];
        of[3 * n + p] += a * a / MEMBERS;
        of[4 * n + p] += a * b / MEMBERS;
        of[5 * n + p] += b * b / MEMBERS;
    }
}
