/* Creep forces from the CSV of `thermoroll table query TABLE.h5 --csv creep_forces.csv`, linear between its nodes.
   Rows: a/b, then magnitude m, then angles alpha, beta of the scaled creepages (xi, eta, phi), beta fastest. */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

enum { RATIO, XI, ETA, PHI, SIZE, ALPHA, BETA, FORCE_X, FORCE_Y, MOMENT, STICK, COLUMNS };
typedef struct { double (*row)[COLUMNS]; int a, m, v, w; } Table;

Table read_table(const char *path) {
    Table t = {malloc(sizeof *t.row), 0, 1, 1, 1};
    FILE *file = fopen(path, "r");
    int rows = 0, c = 0;
    if (!file || fscanf(file, "%*[^\n]") == EOF) { fprintf(stderr, "%s: no table\n", path); exit(1); }
    while (fscanf(file, "%lf%*[,]", &t.row[rows][c]) >= 1)
        if (++c == COLUMNS) { c = 0; t.row = realloc(t.row, (++rows + 1) * sizeof *t.row); }
    fclose(file);
    while (t.row[t.w][BETA] > t.row[t.w - 1][BETA]) t.w++;
    while (t.row[t.v * t.w][ALPHA] > t.row[(t.v - 1) * t.w][ALPHA]) t.v++;
    while (t.m * t.v * t.w < rows && t.row[t.m * t.v * t.w][SIZE] > t.row[(t.m - 1) * t.v * t.w][SIZE]) t.m++;
    t.a = rows / (t.m * t.v * t.w);
    return t;
}

/* Index of the interval of n nodes (every `step` rows, from row `first`) that holds x, and the place in it from 0 to 1. */
static double scaled(double value, int column) {
    return column == RATIO ? log(value) : column == SIZE ? (isinf(value) ? 1.0 : value / (1.0 + value)) : value;
}
static int place(const Table *t, int first, int step, int n, int column, double x, double *part) {
    int i = 0;
    while (i < n - 2 && scaled(t->row[first + (i + 1) * step][column], column) < scaled(x, column)) i++;
    double low = scaled(t->row[first + i * step][column], column);
    double high = n > 1 ? scaled(t->row[first + (i + 1) * step][column], column) : low;
    *part = high > low ? fmin(fmax((scaled(x, column) - low) / (high - low), 0.0), 1.0) : 0.0;
    return i;
}

/* F_x/(mu W), F_y/(mu W), M_z/(mu W sqrt(ab)) and the stick share into `out`; creepages are scaled:
   xi G a b/(mu W), eta G a b/(mu W), phi G (a b)^(3/2)/(mu W). */
void creep_forces(const Table *t, double ratio, double xi, double eta, double phi, double out[4]) {
    const double degree = 57.29577951308232;
    double sign_x = xi < 0 ? -1 : 1, sign_y = eta < 0 ? -1 : 1, part[4];
    int layer = t->m * t->v * t->w, one = t->v * t->w, a = place(t, 0, layer, t->a, RATIO, ratio, &part[0]);
    for (int k = 0; k < 4; k++) out[k] = 0.0;
    for (int da = 0; da < (t->a > 1 ? 2 : 1); da++) {
        int first = (a + da) * layer, unit = first + one;    /* the second magnitude: its creepages give the scales */
        double size = t->row[unit][SIZE], zero = unit + (t->w - 1) / 2;
        double x = fabs(xi) * size / t->row[(int)zero][XI], y = fabs(eta) * size / t->row[(int)zero + (t->v - 1) * t->w][ETA];
        double z = phi * sign_y * size / t->row[unit + t->w - 1][PHI], m = sqrt(x * x + y * y + z * z);
        int i = place(t, first, one, t->m, SIZE, m, &part[1]);
        int j = place(t, first, t->w, t->v, ALPHA, atan2(y, x) * degree, &part[2]);
        int k = place(t, first, 1, t->w, BETA, m > 0 ? asin(z / m) * degree : 0.0, &part[3]);
        for (int corner = 0; corner < 8; corner++) {
            int at[3] = {corner & 1, corner >> 1 & 1, corner >> 2};
            double share = t->a > 1 ? (da ? part[0] : 1 - part[0]) : 1.0;
            for (int n = 0; n < 3; n++) share *= at[n] ? part[n + 1] : 1 - part[n + 1];
            const double *row = t->row[first + (i + at[0]) * one + (j + at[1]) * t->w + k + at[2]];
            for (int n = 0; n < 4; n++) out[n] += share * row[FORCE_X + n];
        }
    }
    out[0] *= sign_x; out[1] *= sign_y; out[2] *= sign_y;
}

int main(int count, char **word) {    /* creep_forces TABLE.csv A/B XI ETA PHI */
    double out[4];
    if (count != 6) return 2;
    Table table = read_table(word[1]);
    creep_forces(&table, atof(word[2]), atof(word[3]), atof(word[4]), atof(word[5]), out);
    printf("%.9g %.9g %.9g %.9g\n", out[0], out[1], out[2], out[3]);
    return 0;
}
