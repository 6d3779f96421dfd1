typedef struct { double of[6]; } networks_results;

static void layer(const double *restrict weights, int size, int units, const double *restrict x, double *restrict z)
{
    for (int k = 0; k < units; k++) {
        double sum = weights[size * units + k];
        for (int i = 0; i < size; i++) sum += weights[i * units + k] * x[i];
        z[k] = STEP * sum;
    }
}

static void hidden(const double *weights, int size, const double *x, double *z)
{
    layer(weights, size, UNITS, x, z);
    for (int k = 0; k < UNITS; k++) z[k] /= sqrt(1.0 + z[k] * z[k]);
}

static networks_results networks(const double logarithms[])
{
    networks_results r = {{1.0, 0.0, 0.0, 0.0, 0.0, 0.0}};
    double x[SIZE], one[UNITS], two[UNITS], out[MEMBERS][2];
    for (int i = 0; i < SIZE; i++) {
        const double low = networks_scales[2][i], high = networks_scales[3][i], reach = FADE * (high - low);
        x[i] = (smaller(larger(logarithms[i], -1e3), 1e3) - networks_scales[0][i]) / networks_scales[1][i];
        r.of[0] = smaller(r.of[0], 1.0 - larger(low - x[i], x[i] - high) / reach);
        x[i] = smaller(larger(x[i], low - reach), high + reach);
    }
    r.of[0] = larger(r.of[0], 0.0);
    r.of[0] *= r.of[0] * (3.0 - 2.0 * r.of[0]);
    for (int m = 0; m < MEMBERS; m++) {
        hidden(networks_weights[m], SIZE, x, one);
        hidden(networks_weights[m] + FIRST, UNITS, one, two);
        layer(networks_weights[m] + SECOND, UNITS, 2, two, out[m]);
        for (int i = 0; i < 2; i++) r.of[1 + i] += out[m][i] / MEMBERS;
    }
    for (int m = 0; m < MEMBERS; m++) {
        const double a = out[m][0] - r.of[1], b = out[m][1] - r.of[2], squares[3] = {a * a, a * b, b * b};
        for (int i = 0; i < 3; i++) r.of[3 + i] += squares[i] / MEMBERS;
    }
    return r;
}
