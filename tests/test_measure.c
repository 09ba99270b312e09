/* The error figures, by hand and against a slow twin. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include <penumbra/penumbra.h>

static pnb_context *context;

static int set_up(void **state)
{
    return pnb_context_create(NULL, &context) != PNB_OK;
}

static int tear_down(void **state)
{
    pnb_context_destroy(context);
    return 0;
}

static void figures_by_hand(void **state)
{
    const float nan = NAN;
    const float truth[] = {0, 0, 0, 0, 1, 1, 0.5f, 0.25f, 0.5f, nan, 0.5f, 0.5f};
    const float value[] = {0, 0.5f, 0, 0.003f, 1, 0.75f, 0.5f, 0.5f, nan, 1, 0, 1};
    const uint8_t mask[] = {1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 0};
    pnb_errors e;
    assert_int_equal(pnb_measure(context, value, truth, mask, 12, &e), PNB_OK);
    assert_int_equal(e.pixels, 8);
    /* The leak, the dark spot, and the two true penumbra points: 0.5, -0.25, 0, 0.25. */
    assert_int_equal(e.penumbra_pixels, 4);
    assert_float_equal(e.rmse, sqrt((0.25 + 0.0625 + 0 + 0.0625) / 4), 1e-12);
    assert_float_equal(e.mean_error, 0.125, 1e-12);
    assert_float_equal(e.p99_error, 0.5, 0);
    assert_float_equal(e.max_error, 0.5, 0);
    assert_float_equal(e.umbra_leak, 0.25, 1e-12);
    assert_float_equal(e.lit_darkening, 0.5, 1e-12);
}

static void nothing_to_measure_is_zero(void **state)
{
    pnb_errors e, zero = {0};
    const float none[] = {NAN, 0.5f};
    const uint8_t mask[] = {1, 0};
    assert_int_equal(pnb_measure(context, none, none, mask, 2, &e), PNB_OK);
    assert_memory_equal(&e, &zero, sizeof(e));
    assert_int_equal(pnb_measure(context, NULL, NULL, NULL, 0, &e), PNB_OK);
    assert_memory_equal(&e, &zero, sizeof(e));
}

static int by_value(const void *a, const void *b)
{
    float x = *(const float *)a, y = *(const float *)b;
    return (x > y) - (x < y);
}

/* The definitions read aloud, one figure at a time. */
static void twin(const float *v, const float *t, const uint8_t *mask, size_t n, pnb_errors *e)
{
    float *sizes = malloc((n + 1) * sizeof(*sizes));
    memset(e, 0, sizeof(*e));
    double umbra = 0, leak = 0, lit = 0, dark = 0;
    for (size_t i = 0; i < n; i++) {
        if (!mask[i] || isnan(v[i]) || isnan(t[i]))
            continue;
        double d = (double)v[i] - t[i];
        e->pixels++;
        if (fabs(d) > e->max_error)
            e->max_error = fabs(d);
        umbra += t[i] == 0;
        leak += t[i] == 0 && v[i] > 1 / 255.0;
        lit += t[i] == 1;
        dark += t[i] == 1 && v[i] < 254 / 255.0;
        if (!(t[i] > 0 && t[i] < 1) && !(fabs(d) > 1 / 255.0))
            continue;
        sizes[e->penumbra_pixels++] = (float)fabs(d);
        e->rmse += d * d;
        e->mean_error += d;
    }
    e->umbra_leak = umbra > 0 ? leak / umbra : 0;
    e->lit_darkening = lit > 0 ? dark / lit : 0;
    if (e->penumbra_pixels) {
        e->rmse = sqrt(e->rmse / (double)e->penumbra_pixels);
        e->mean_error /= (double)e->penumbra_pixels;
        qsort(sizes, e->penumbra_pixels, sizeof(*sizes), by_value);
        size_t k = 0; /* the first that at least 99 % do not exceed */
        while (100 * (k + 1) < 99 * e->penumbra_pixels)
            k++;
        e->p99_error = sizes[k];
    }
    free(sizes);
}

static void agrees_with_the_twin(void **state)
{
    enum { MOST = 700 };
    float v[MOST], t[MOST];
    uint8_t mask[MOST];
    uint32_t seed = 1;
    for (size_t n = 1; n < MOST; n += 1 + n / 40)
        for (int kind = 0; kind < 3; kind++) {
            for (size_t i = 0; i < n; i++) {
                seed = seed * 1664525u + 1013904223u;
                /* Many equal values in one kind, many different in another. */
                float x = kind == 0 ? (float)(seed >> 30) / 3 : (float)(seed >> 8) / (1 << 24);
                seed = seed * 1664525u + 1013904223u;
                float y = kind == 1 ? x + 0.01f * (float)(seed >> 28) : (float)(seed >> 30) / 3;
                t[i] = x, v[i] = (seed & 0x700) ? y : NAN;
                mask[i] = (seed & 0x3000) != 0;
            }
            pnb_errors a, b;
            assert_int_equal(pnb_measure(context, v, t, mask, n, &a), PNB_OK);
            twin(v, t, mask, n, &b);
            assert_int_equal(a.pixels, b.pixels);
            assert_int_equal(a.penumbra_pixels, b.penumbra_pixels);
            assert_float_equal(a.rmse, b.rmse, 1e-12);
            assert_float_equal(a.mean_error, b.mean_error, 1e-12);
            assert_float_equal(a.p99_error, b.p99_error, 0);
            assert_float_equal(a.max_error, b.max_error, 0);
            assert_float_equal(a.umbra_leak, b.umbra_leak, 1e-12);
            assert_float_equal(a.lit_darkening, b.lit_darkening, 1e-12);
        }
}

static void facing_is_the_whole_light(void **state)
{
    /* half_u x half_v points down: so does the lit side. */
    const pnb_light light = {
        .type = PNB_LIGHT_RECTANGLE,
        .color = {1, 1, 1},
        .shape.rectangle = {.center = {0, 4, 0}, .half_u = {1, 0, 0}, .half_v = {0, 0, 1}}};
    /* Under the light; behind it; a wall that sees half of it; nothing there. */
    const float positions[] = {0, 0, 0, 0, 8, 0, 0, 0, 0, NAN, NAN, NAN};
    const float normals[] = {0, 1, 0, 0, -1, 0, 1, 0, 0, 0, 1, 0};
    pnb_receivers receivers = {.count = 4, .positions = positions, .normals = normals};
    uint8_t mask[4];
    pnb_measure_facing(&light, &receivers, mask);
    const uint8_t expected[] = {1, 0, 0, 0};
    assert_memory_equal(mask, expected, 4);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(figures_by_hand),
        cmocka_unit_test(nothing_to_measure_is_zero),
        cmocka_unit_test(agrees_with_the_twin),
        cmocka_unit_test(facing_is_the_whole_light),
    };
    return cmocka_run_group_tests_name("measure", tests, set_up, tear_down);
}
