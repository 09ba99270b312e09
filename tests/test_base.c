/* Parallel loops, memory, errors. */
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <stdlib.h>
#include <string.h>

#include "base/base.h"

static void add_one(void *user, size_t begin, size_t end, int worker)
{
    int *hits = user;
    for (size_t i = begin; i < end; i++)
        hits[i] += 1;
}

static void loop_covers_each_item_once(void **state)
{
    for (int threads = 1; threads <= 5; threads++) {
        pnb_context *context;
        assert_int_equal(pnb_context_create(&(pnb_context_desc){.threads = threads}, &context),
                         PNB_OK);
        for (size_t count = 0; count < 3000; count = count * 2 + 1) {
            int *hits = calloc(count + 1, sizeof(*hits));
            parallel_for(context, count, 7, add_one, hits);
            for (size_t i = 0; i < count; i++)
                assert_int_equal(hits[i], 1);
            assert_int_equal(hits[count], 0);
            free(hits);
        }
        pnb_context_destroy(context);
    }
}

static bool stop_at_once(void *user, const char *stage, double fraction)
{
    return false;
}

static void progress_cancels(void **state)
{
    pnb_context *context;
    int hits[100] = {0};
    assert_int_equal(pnb_context_create(&(pnb_context_desc){.progress = stop_at_once}, &context),
                     PNB_OK);
    assert_int_equal(parallel_for_progress(context, "counting", 0, 1, 100, 1, add_one, hits),
                     PNB_ERROR_CANCELLED);
    assert_string_equal(pnb_context_error(context), "counting: cancelled");
    pnb_context_destroy(context);
}

static void errors_are_one_line(void **state)
{
    pnb_context *context;
    assert_int_equal(pnb_context_create(NULL, &context), PNB_OK);
    assert_string_equal(pnb_context_error(context), "");
    assert_int_equal(status_fail(context, PNB_ERROR_FILE, "a\nb", "%s", "c\x1b[31m"),
                     PNB_ERROR_FILE);
    assert_string_equal(pnb_context_error(context), "a?b: c?[31m");
    char *long_text = malloc(5000);
    memset(long_text, 'x', 4999);
    long_text[4999] = 0;
    status_fail(context, PNB_ERROR_FILE, long_text, "%s", long_text);
    assert_true(strlen(pnb_context_error(context)) < 1024);
    free(long_text);
    pnb_context_destroy(context);
}

static void *counting_reallocate(void *user, void *old, size_t size)
{
    int *live = user;
    if (!old)
        ++*live;
    if (size == 0) {
        --*live;
        free(old);
        return NULL;
    }
    return realloc(old, size);
}

static void allocator_balances(void **state)
{
    int live = 0;
    pnb_context *context;
    pnb_context_desc desc = {.threads = 3, .reallocate = counting_reallocate, .user = &live};
    assert_int_equal(pnb_context_create(&desc, &context), PNB_OK);
    int hits[100] = {0};
    parallel_for(context, 100, 1, add_one, hits);
    assert_null(memory_alloc(context, SIZE_MAX / 2, 3));
    memory_free(context, memory_calloc(context, 0, 8));
    pnb_context_destroy(context);
    assert_int_equal(live, 0);
}

int main(void)
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(loop_covers_each_item_once),
        cmocka_unit_test(progress_cancels),
        cmocka_unit_test(errors_are_one_line),
        cmocka_unit_test(allocator_balances),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
