/* Creep forces from the CSV of `thermoroll table query TABLE.h5 --csv TABLE.csv`, linear between its nodes:
   creep_forces TABLE.csv A/B XI ETA PHI prints F_x/(mu W), F_y/(mu W), M_z/(mu W sqrt(ab)) and the stick share.
   Creepages are scaled as in the table: xi G a b/(mu W), eta G a b/(mu W), phi G (a b)^(3/2)/(mu W). */
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
enum { RATIO, SIZE = 4, ALPHA, BETA, PER_XI, PER_ETA, PER_PHI, FORCE, COLUMNS = 14, ROWS = 300000 };
static double table[ROWS][COLUMNS];
static double place(int key, double x) { return key == RATIO ? log(x) : key == SIZE ? 1 - 1 / (1 + x) : x; }

/* Adds `share` of the outputs at x = {a/b, magnitude, alpha, beta} to `out`; the n rows differ in the last `keys` of x. */
static void add(const double (*row)[COLUMNS], int n, int keys, double x[4], const double creepage[3], double share, double out[4]) {
    int key = keys == 4 ? RATIO : BETA + 1 - keys, step = 1;
    if (keys == 0) { for (int k = 0; k < 4; k++) out[k] += share * row[0][FORCE + k]; return; }
    if (keys == 3) {    /* one a/b, whose scales are known */
        double xi = creepage[0] * row[0][PER_XI], eta = creepage[1] * row[0][PER_ETA], phi = creepage[2] * row[0][PER_PHI];
        x[1] = hypot(hypot(xi, eta), phi);
        x[2] = atan2(eta, xi) * 180 / acos(-1);
        x[3] = atan2(phi, hypot(xi, eta)) * 180 / acos(-1);
    }
    while (step < n && row[step][key] == row[0][key]) step++;
    for (; n > 2 * step && row[step][key] < x[4 - keys]; row += step) n -= step;
    double low = place(key, row[0][key]), high = place(key, row[n > step ? step : 0][key]);
    double part = high > low ? fmin(fmax((place(key, x[4 - keys]) - low) / (high - low), 0), 1) : 0;
    add(row, step, keys - 1, x, creepage, share * (1 - part), out);
    if (part > 0) add(row + step, step, keys - 1, x, creepage, share * part, out);
}

int main(int count, char **word) {
    FILE *file = count == 6 ? fopen(word[1], "r") : NULL;
    int cells = 0;
    if (!file || fscanf(file, "%*[^\n]") == EOF) return 2;
    while (cells < ROWS * COLUMNS && fscanf(file, "%lf%*[,]", table[0] + cells) >= 1) cells++;
    double x[4] = {atof(word[2])}, out[4] = {0}, xi = atof(word[3]), eta = atof(word[4]), sign = eta < 0 ? -1 : 1;
    add(table, cells / COLUMNS, 4, x, (double[3]){fabs(xi), fabs(eta), sign * atof(word[5])}, 1, out);
    printf("%.9g %.9g %.9g %.9g\n", xi < 0 ? -out[0] : out[0], sign * out[1], sign * out[2], out[3]);
}
