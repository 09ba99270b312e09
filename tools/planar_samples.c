/* tools/planar_samples.c: makes src/method/planar/sample_tables.h: light samples for the ring rule.
 *
 *     planar-samples > src/method/planar/sample_tables.h      (some minutes)
 *
 * With K samples the ring rule draws a penumbra whose profile, for a long straight occluder edge in
 * direction d, is piecewise linear: (i - 1)/(K - 1) where the i-th of the samples' sorted
 * projections onto d lies. The truth is the share of the light's area below that projection. Chosen
 * are the samples for which the squared difference, summed over all directions and places, is
 * least: simulated annealing from several starts, then smaller and smaller steps. Shapes that an
 * affine map turns into one another share a table, since area shares stay what they are.
 *
 * Deterministic: the same program writes the same file on one machine.
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define DIRECTIONS 60
#define STEPS      128
#define K_MAX      64

enum shape { SQUARE, DISK, TRIANGLE };

static uint64_t state;
static double uniform(void)
{
    state ^= state << 13;
    state ^= state >> 7;
    state ^= state << 17;
    return (double)(state >> 11) * 0x1p-53;
}

/* Share of the light's area with projection below s, on a grid over [lo, hi]. */
struct curve {
    double cx, cy, lo, hi, weight, share[STEPS + 1];
};
static struct curve curves[DIRECTIONS];

static int inside(enum shape shape, double x, double y)
{
    switch (shape) {
    case SQUARE: return fabs(x) <= 1 && fabs(y) <= 1;
    case DISK: return x * x + y * y <= 1;
    case TRIANGLE: return x >= 0 && y >= 0 && x + y <= 1;
    }
    return 0;
}

static void make_curves(enum shape shape)
{
    enum { grid = 1200 };
    for (int d = 0; d < DIRECTIONS; d++) {
        struct curve *c = &curves[d];
        /* The triangle is a unit corner here; directions of its equilateral image would weigh it
         * evenly. */
        double angle = 3.14159265358979323846 * (d + 0.37) / DIRECTIONS;
        double ex = cos(angle), ey = sin(angle);
        /* Rectangular lights hang square to what they light more often than not. */
        double off = fmin(fabs(ex), fabs(ey));
        c->weight = shape == SQUARE ? 1 + 4 * exp(-pow(off / 0.15, 2)) : 1;
        if (shape == TRIANGLE) { /* pull back through (x, y) -> (x + y/2, y sqrt(3)/2) */
            c->cx = ex;
            c->cy = 0.5 * ex + 0.86602540378443865 * ey;
        } else {
            c->cx = ex;
            c->cy = ey;
        }
        c->lo = 1e30;
        c->hi = -1e30;
        double histogram[STEPS] = {0}, total = 0;
        for (int pass = 0; pass < 2; pass++)
            for (int i = 0; i < grid; i++)
                for (int j = 0; j < grid; j++) {
                    double x = -1 + 2 * (i + 0.5) / grid, y = -1 + 2 * (j + 0.5) / grid;
                    if (!inside(shape, x, y))
                        continue;
                    double s = x * c->cx + y * c->cy;
                    if (pass == 0) {
                        c->lo = fmin(c->lo, s);
                        c->hi = fmax(c->hi, s);
                    } else {
                        int k = (int)((s - c->lo) / (c->hi - c->lo) * STEPS);
                        histogram[k < STEPS ? k : STEPS - 1] += 1;
                        total += 1;
                    }
                }
        c->share[0] = 0;
        for (int k = 0; k < STEPS; k++)
            c->share[k + 1] = c->share[k] + histogram[k] / total;
    }
}

/* The root of the mean over directions of the square of each direction's mean squared error: a set
 * that is good on the whole and bad in some directions would show on every edge that runs there. */
static double cost(const double *p, int count)
{
    double squares = 0, weights = 0;
    for (int d = 0; d < DIRECTIONS; d++) {
        const struct curve *c = &curves[d];
        double s[K_MAX];
        for (int i = 0; i < count; i++) {
            double v = p[2 * i] * c->cx + p[2 * i + 1] * c->cy;
            int j = i;
            for (; j > 0 && s[j - 1] > v; j--)
                s[j] = s[j - 1];
            s[j] = v;
        }
        int i = 0;
        double sum = 0;
        double width = c->hi - c->lo;
        for (int k = 0; k <= STEPS; k++) {
            double at = c->lo + width * k / STEPS, ring;
            while (i < count && s[i] <= at)
                i++;
            if (i == 0)
                ring = 0;
            else if (i == count)
                ring = 1;
            else
                ring = (i - 1 + (at - s[i - 1]) / (s[i] - s[i - 1] + 1e-12)) / (count - 1);
            double e = ring - c->share[k];
            sum += e * e;
        }
        sum /= STEPS + 1.0;
        squares += c->weight * sum * sum;
        weights += c->weight;
    }
    return sqrt(squares / weights);
}

static double anneal(enum shape shape, int count, double *best)
{
    double best_cost = 1e30;
    int starts = count <= 8 ? 6 : count <= 16 ? 3 : 1;
    int moves = count <= 8 ? 12000 : count <= 16 ? 20000 : 30000;
    for (int start = 0; start < starts; start++) {
        double p[2 * K_MAX];
        for (int i = 0; i < count; i++)
            do {
                p[2 * i] = 2 * uniform() - 1;
                p[2 * i + 1] = 2 * uniform() - 1;
            } while (!inside(shape, p[2 * i], p[2 * i + 1]));
        double now = cost(p, count);
        for (int m = 0; m < moves; m++) {
            double t = (double)m / moves;
            double step = 0.6 * pow(0.004, t), heat = now * 0.05 * pow(0.0005, t);
            int i = (int)(uniform() * count);
            double x = p[2 * i], y = p[2 * i + 1];
            p[2 * i] += step * (2 * uniform() - 1);
            p[2 * i + 1] += step * (2 * uniform() - 1);
            double next = inside(shape, p[2 * i], p[2 * i + 1]) ? cost(p, count) : 1e30;
            if (next <= now || uniform() < exp((now - next) / heat)) {
                now = next;
            } else {
                p[2 * i] = x;
                p[2 * i + 1] = y;
            }
            if (now < best_cost) {
                best_cost = now;
                memcpy(best, p, 2 * (size_t)count * sizeof(*p));
            }
        }
    }
    return best_cost;
}

int main(void)
{
    static const int counts[] = {2, 3, 4, 5, 6, 7, 8, 10, 12, 16, 24, 32, 48, 64};
    static const char *names[] = {"square", "disk", "triangle"};
    enum { count_count = sizeof(counts) / sizeof(counts[0]) };
    printf("/* Made by tools/planar_samples.c. Light samples for the ring rule: (x, y) in [-1, "
           "1]^2, in "
           "the unit\n * disk, and in the triangle (0, 0) (1, 0) (0, 1). */\n");
    printf("/* clang-format off */\n");
    for (int shape = 0; shape < 3; shape++) {
        make_curves((enum shape)shape);
        for (int c = 0; c < count_count; c++) {
            double best[2 * K_MAX];
            state = 88172645463325252u + (uint64_t)(shape * 100 + counts[c]);
            double error = anneal((enum shape)shape, counts[c], best);
            printf("/* profile RMSE %.4f */\nstatic const float %s_%d[] = {", sqrt(error),
                   names[shape], counts[c]);
            for (int i = 0; i < 2 * counts[c]; i++)
                printf("%s%.4ff", i == 0 ? "" : i % 12 == 0 ? ",\n    " : ", ", best[i]);
            printf("};\n");
            fflush(stdout);
        }
    }
    printf("\nstatic const struct sample_table {\n    int shape, count; /* 0: square, 1: disk, 2: "
           "triangle "
           "*/\n    const float *points;\n} sample_tables[] = {\n");
    for (int shape = 0; shape < 3; shape++)
        for (int c = 0; c < count_count; c++)
            printf("    {%d, %d, %s_%d},\n", shape, counts[c], names[shape], counts[c]);
    printf("};\n/* clang-format on */\n");
    return 0;
}
