/* 'penumbra compare' as its user sees it: exit status, report.json, the page. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <ctype.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <jansson.h>

#include <penumbra/penumbra.h>

static char folder[64];

static const char scene_text[] =
    "{\"camera\": {\"eye\": [0, 3, 6], \"target\": [0, 0.5, 0]},"
    " \"lights\": [{\"type\": \"rectangle\", \"center\": [1, 4, 1], \"half_u\": [0.6, 0, 0],"
    " \"half_v\": [0, 0, 0.6], \"color\": [10, 10, 10]},"
    " {\"type\": \"point\", \"position\": [-1, 4, 1], \"color\": [3, 3, 3]}],"
    " \"objects\": [{\"name\": \"ground\", \"plane\": {\"point\": [0, 0, 0],"
    " \"normal\": [0, 1, 0], \"half_size\": 10}, \"color\": [0.8, 0.8, 0.8]},"
    " {\"name\": \"board\", \"plane\": {\"point\": [0, 1, 0], \"normal\": [0, 1, 0],"
    " \"half_size\": 0.7}, \"color\": [0.7, 0.3, 0.2]}]}";

static int set_up(void **state)
{
    strcpy(folder, "/tmp/pnb-compare-XXXXXX");
    if (!mkdtemp(folder))
        return -1;
    char path[128];
    snprintf(path, sizeof(path), "%s/<a&b>.json", folder); /* a name that must be escaped */
    FILE *file = fopen(path, "w");
    return !file || fputs(scene_text, file) < 0 || fclose(file) != 0;
}

static int tear_down(void **state)
{
    char command[128];
    snprintf(command, sizeof(command), "rm -rf '%s'", folder);
    return system(command);
}

/* Runs the program in the folder; what it says on both streams goes into text. */
static int run(char *text, size_t size, const char *arguments)
{
    char command[1024], path[128];
    snprintf(path, sizeof(path), "%s/said", folder);
    snprintf(command, sizeof(command), "cd '%s' && ('%s/penumbra' %s) > said 2>&1", folder,
             getenv("PNB_BUILD_DIR"), arguments);
    int status = system(command);
    FILE *file = fopen(path, "r");
    assert_non_null(file);
    size_t length = fread(text, 1, size - 1, file);
    text[length] = 0;
    fclose(file);
    return WEXITSTATUS(status);
}

static bool exists(const char *name)
{
    char path[256];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    return access(path, F_OK) == 0;
}

static char *read_text(const char *name)
{
    char path[256];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "rb");
    assert_non_null(file);
    fseek(file, 0, SEEK_END);
    long size = ftell(file);
    rewind(file);
    char *text = malloc((size_t)size + 1);
    assert_int_equal(fread(text, 1, (size_t)size, file), size);
    text[size] = 0;
    fclose(file);
    return text;
}

static json_t *read_report(const char *name)
{
    char *text = read_text(name);
    json_t *report = json_loads(text, 0, NULL);
    free(text);
    assert_non_null(report);
    return report;
}

static double number(const json_t *object, const char *key)
{
    const json_t *value = json_object_get(object, key);
    if (!json_is_number(value))
        fail_msg("%s is no number", key);
    return json_number_value(value);
}

static void report_keeps_the_contract(void **state)
{
    char said[8192];
    int status = run(said, sizeof(said),
                     "compare '<a&b>.json' --methods reference:4,reference:64 -s 80x60 "
                     "--truth-samples 1024 -o out");
    if (status != 0)
        print_error("%s", said);
    assert_int_equal(status, 0);
    json_t *report = read_report("out/report.json");
    json_t *scenes = json_object_get(report, "scenes");
    assert_int_equal(json_array_size(scenes), 1);
    json_t *scene = json_array_get(scenes, 0);
    assert_string_equal(json_string_value(json_object_get(scene, "scene")), "<a&b>.json");
    assert_int_equal(number(scene, "width"), 80);
    assert_int_equal(number(scene, "height"), 60);
    assert_int_equal(number(scene, "light"), 0);
    json_t *truth = json_object_get(scene, "truth");
    assert_string_equal(json_string_value(json_object_get(truth, "method")), "reference");
    assert_int_equal(number(truth, "samples"), 1024);
    assert_true(number(truth, "milliseconds") > 0);
    json_t *methods = json_object_get(scene, "methods");
    assert_int_equal(json_array_size(methods), 2);
    for (size_t i = 0; i < 2; i++) {
        json_t *method = json_array_get(methods, i);
        assert_string_equal(json_string_value(json_object_get(method, "name")), "reference");
        assert_int_equal(number(method, "samples"), i == 0 ? 4 : 64);
        assert_true(number(method, "milliseconds") > 0);
        assert_true(number(method, "rmse") > 0);
        assert_true(fabs(number(method, "mean_error")) < 0.05);
        assert_true(number(method, "max_error") >= number(method, "p99_error"));
        assert_true(number(method, "umbra_leak") >= 0);
        assert_true(number(method, "lit_darkening") >= 0);
        assert_true(number(method, "pixels") > 1000);
        assert_true(json_is_array(json_object_get(method, "warnings")));
    }
    assert_true(number(json_array_get(methods, 0), "rmse") >
                2 * number(json_array_get(methods, 1), "rmse"));
    json_decref(report);
    assert_non_null(strstr(said, "out/index.html"));
}

static void page_is_self_contained(void **state)
{
    char said[8192];
    assert_int_equal(run(said, sizeof(said),
                         "compare '<a&b>.json' --methods reference:4,reference:16 -s 80x60 "
                         "--truth-samples 64 -q -o out/"),
                     0);
    assert_string_equal(said, "");
    char *page = read_text("out/index.html");
    /* Nothing is fetched: whatever is referred to lies within. */
    for (char *at = page; (at = strstr(at, "://")); at++)
        fail_msg("the page names an address: %.40s", at - 10);
    const char *const attributes[] = {"src=\"", "href=\"", "url("};
    for (int i = 0; i < 3; i++)
        for (char *at = page; (at = strstr(at, attributes[i]));) {
            at += strlen(attributes[i]);
            assert_true(strncmp(at, "data:", 5) == 0 || *at == '#');
        }
    assert_null(strstr(page, "@import"));
    assert_null(strstr(page, "<a&b>"));
    assert_non_null(strstr(page, "&lt;a&amp;b&gt;.json"));
    /* truth: 2 images, each method: 3. */
    int images = 0;
    for (char *at = page; (at = strstr(at, "data:image/png;base64,iVBOR")); at++)
        images++;
    assert_int_equal(images, 8);
    const char *const wanted[] = {"<title>",      "class=\"wipe\"",      "class=\"plot\"",
                                  "reference:16", "class=\"histogram\"", "prefers-color-scheme",
                                  "</html>"};
    for (size_t i = 0; i < sizeof(wanted) / sizeof(wanted[0]); i++)
        assert_non_null(strstr(page, wanted[i]));
    /* The command is there to be repeated. */
    assert_non_null(strstr(page, "penumbra compare &#39;&lt;a&amp;b&gt;.json&#39; --methods "
                                 "reference:4,reference:16 -s 80x60"));
    free(page);
}

/* One method several times, each with settings of its own; -p is for those that do not set it. */
static void entries_have_settings_of_their_own(void **state)
{
    char said[8192];
    assert_int_equal(run(said, sizeof(said),
                         "compare builtin:two-boxes builtin:pole -s 80x60 --truth-samples 64 -q -o "
                         "out -p placement=random --methods "
                         "planar:3,planar:n=8:placement=border,planar:fill=sweep,planar:n=3"),
                     0);
    assert_string_equal(said, "");
    json_t *report = read_report("out/report.json");
    json_t *scene = json_array_get(json_object_get(report, "scenes"), 1);
    json_t *methods = json_object_get(scene, "methods");
    const struct {
        const char *label, *placement, *fill;
        int samples;
    } wanted[] = {{"planar:3", "random", "nearest", 3},
                  {"planar:8:placement=border", "border", "nearest", 8},
                  {"planar:fill=sweep", "random", "sweep", 16}};
    assert_int_equal(json_array_size(methods), 3);
    for (size_t i = 0; i < 3; i++) {
        json_t *method = json_array_get(methods, i);
        json_t *params = json_object_get(method, "parameters");
        assert_string_equal(json_string_value(json_object_get(method, "label")), wanted[i].label);
        assert_string_equal(json_string_value(json_object_get(params, "placement")),
                            wanted[i].placement);
        assert_string_equal(json_string_value(json_object_get(params, "fill")), wanted[i].fill);
        assert_int_equal(json_integer_value(json_object_get(method, "samples")), wanted[i].samples);
    }
    json_decref(report);
    /* With several scenes the page begins with a summary. */
    char *page = read_text("out/index.html");
    const char *const parts[] = {"id=\"summary\"", "class=\"advice\"", "class=\"matrix\"",
                                 "class=\"front\""};
    for (size_t i = 0; i < sizeof(parts) / sizeof(parts[0]); i++)
        assert_non_null(strstr(page, parts[i]));
    free(page);
}

/* A method moves as the truth does but for its errors; the same on every run. */
static void motion_is_measured(void **state)
{
    char said[8192];
    double flicker[2][2];
    for (int turn = 0; turn < 2; turn++) {
        char line[300];
        snprintf(line, sizeof(line),
                 "compare builtin:two-boxes -s 160x120 --truth-samples 64 -q -o out --motion "
                 "--motion-frames 4 --motion-path %s --methods exact,hard-map",
                 turn ? "occluder" : "light");
        assert_int_equal(run(said, sizeof(said), line), 0);
        assert_string_equal(said, "");
        json_t *report = read_report("out/report.json");
        json_t *scene = json_array_get(json_object_get(report, "scenes"), 0);
        json_t *motion = json_object_get(scene, "motion");
        json_t *methods = json_object_get(motion, "methods");
        assert_int_equal(json_integer_value(json_object_get(motion, "frames")), 4);
        assert_int_equal(json_array_size(methods), 2);
        for (size_t i = 0; i < 2; i++) {
            json_t *method = json_array_get(methods, i);
            flicker[turn][i] = number(method, "flicker");
            assert_int_equal(json_array_size(json_object_get(method, "steps")), 3);
            assert_true(number(method, "popping") >= flicker[turn][i]);
            assert_true(number(method, "truth_change") > 0);
        }
        assert_true(flicker[turn][0] < 0.005);
        assert_true(flicker[turn][1] > 0.02);
        json_decref(report);
    }
    char *page = read_text("out/index.html");
    assert_non_null(strstr(page, "id=\"motion\""));
    free(page);
}

static void files_of_other_programs_are_judged(void **state)
{
    char said[8192];
    assert_int_equal(run(said, sizeof(said),
                         "render '<a&b>.json' -m reference -n 1024 -s 80x60 -o p.exr --visibility "
                         "v.pfm -q"),
                     0);
    /* The EXR holds a visibility beside the picture, the PNG the picture alone. */
    assert_int_equal(
        run(said, sizeof(said), "render '<a&b>.json' -m reference -n 1024 -s 80x60 -o p.png -q"),
        0);
    assert_int_equal(run(said, sizeof(said),
                         "compare '<a&b>.json' -s 80x60 --truth-samples 1024 --image v.pfm "
                         "--image p.exr --image p.png -o out --json -q"),
                     0);
    json_t *report = json_loads(said, 0, NULL);
    assert_non_null(report);
    json_t *scene = json_array_get(json_object_get(report, "scenes"), 0);
    json_t *methods = json_object_get(scene, "methods");
    assert_int_equal(json_array_size(methods), 3);
    const char *const kinds[] = {"visibility", "visibility", "picture"};
    for (size_t i = 0; i < 3; i++) {
        json_t *method = json_array_get(methods, i);
        assert_string_equal(json_string_value(json_object_get(method, "kind")), kinds[i]);
        assert_true(number(method, "rmse") < 0.01);
        assert_true(number(method, "umbra_leak") < 0.01);
        assert_true(number(method, "pixels") > 1000);
        assert_true(json_is_null(json_object_get(method, "milliseconds")));
    }
    json_decref(report);
}

/* Each fails in one line and leaves no folder behind. */
static void mistakes_leave_nothing(void **state)
{
    static const struct {
        int status;
        const char *arguments, *said;
    } cases[] = {
        {2, "compare '<a&b>.json'", "-o"},
        {2, "compare -o no", "SCENE"},
        {2, "compare '<a&b>.json' -o no --methods nothing", "nothing"},
        {2, "compare '<a&b>.json' -o no --methods reference:x", "x"},
        {2, "compare '<a&b>.json' -o no --methods reference:0", "0"},
        {2, "compare '<a&b>.json' -o no --methods planar:n=x", "x"},
        {2, "compare '<a&b>.json' -o no --motion-path sideways", "sideways"},
        {2, "compare '<a&b>.json' -o no --motion-frames 1", "1"},
        {2, "compare '<a&b>.json' -o no --methods planar:nothing=1", "nothing"},
        {2, "compare '<a&b>.json' -o no --methods planar:fill=wrong", "wrong"},
        {2, "compare '<a&b>.json' -o no --methods exact,", "no method"},
        {2, "compare '<a&b>.json' -o no --truth-samples -4", "-4"},
        {2, "compare '<a&b>.json' -o no --light-index 7", "7"},
        {2, "compare a b -o no --image v.pfm", "--image"},
        {1, "compare missing.json -o no", "missing.json"},
        {1, "compare '<a&b>.json' -o no --image missing.pfm", "missing.pfm"},
        {1, "compare '<a&b>.json' -o no --image '<a&b>.json'", "<a&b>.json"},
        {1, "compare '<a&b>.json' -s 80x61 --image v.pfm -o no", "80x60"},
        {1, "compare '<a&b>.json' -o no/where/to", "no/where"},
        {1, "compare '<a&b>.json' -o '<a&b>.json'", "folder"},
    };
    char said[8192];
    assert_int_equal(
        run(said, sizeof(said),
            "render '<a&b>.json' -m reference -n 16 -s 80x60 -o p.png --visibility v.pfm -q"),
        0);
    for (size_t i = 0; i < sizeof(cases) / sizeof(cases[0]); i++) {
        int status = run(said, sizeof(said), cases[i].arguments);
        if (status != cases[i].status || !strstr(said, cases[i].said))
            fail_msg("%s: %d: %s", cases[i].arguments, status, said);
        assert_ptr_equal(strstr(said, "penumbra: error: "), said);
        assert_ptr_equal(strchr(said, '\n'), said + strlen(said) - 1);
        assert_false(exists("no"));
    }
}

static void write_text(const char *name, const char *text)
{
    char path[256];
    snprintf(path, sizeof(path), "%s/%s", folder, name);
    FILE *file = fopen(path, "w");
    assert_non_null(file);
    assert_true(fputs(text, file) >= 0);
    assert_int_equal(fclose(file), 0);
}

/* A scene without a plane that receives is none for the method planar. With this truth the
 * comparison would take hours: it must be found out before. */
static void methods_that_cannot_are_found_out_first(void **state)
{
    write_text("bare.json", "{\"lights\": [{\"type\": \"point\", \"position\": [1, 4, 1]}],"
                            " \"objects\": [{\"plane\": {\"half_size\": 5},"
                            " \"receives\": false}]}");
    char said[8192];
    int status = run(said, sizeof(said),
                     "compare bare.json --methods reference:64,planar -o out "
                     "--truth-samples 262144 -s 1600x1200");
    assert_int_equal(status, 1);
    assert_ptr_equal(strstr(said, "penumbra: error: "), said);
    assert_ptr_equal(strchr(said, '\n'), said + strlen(said) - 1);
    assert_non_null(strstr(said, "these methods do other receivers: reference"));
    assert_false(exists("out"));

    status = run(said, sizeof(said),
                 "compare bare.json bare.json --methods planar -o out --truth-samples 262144");
    assert_int_equal(status, 1);
    assert_non_null(strstr(said, "no method is left"));
    assert_false(exists("out"));

    status = run(said, sizeof(said),
                 "compare bare.json '<a&b>.json' --methods planar,reference:16 -o out "
                 "--truth-samples 1024 -s 80x60");
    if (status != 0)
        fail_msg("%s", said);
    assert_non_null(strstr(said, "penumbra: warning: bare.json: planar is left out: "));
    char *page = read_text("out/index.html");
    assert_non_null(strstr(page, "planar is left out: "));
    free(page);
    json_t *report = read_report("out/report.json");
    const json_t *scenes = json_object_get(report, "scenes");
    for (size_t i = 0; i < 2; i++) {
        const json_t *scene = json_array_get(scenes, i);
        assert_int_equal(json_array_size(json_object_get(scene, "methods")), 1 + i);
        assert_int_equal(json_array_size(json_object_get(scene, "notes")), 1 - i);
    }
    json_decref(report);
}

/* A limit on the size of files stands for a full disk. */
static void full_disk_keeps_the_old_report(void **state)
{
    char said[8192], before[256], after[256];
    assert_int_equal(run(said, sizeof(said),
                         "compare '<a&b>.json' -s 40x30 --truth-samples 16 --methods reference:4 "
                         "-q -o out"),
                     0);
    char *page = read_text("out/index.html");
    snprintf(before, sizeof(before), "%zu", strlen(page));
    free(page);
    int status = run(said, sizeof(said),
                     "methods > /dev/null; ulimit -f 4; \"$PNB_BUILD_DIR/penumbra\" compare "
                     "'<a&b>.json' -s 80x60 --truth-samples 16 --methods reference:4 -q -o out");
    assert_int_equal(status, 1);
    assert_non_null(strstr(said, "index.html"));
    page = read_text("out/index.html");
    snprintf(after, sizeof(after), "%zu", strlen(page));
    free(page);
    assert_string_equal(before, after);
    run(said, sizeof(said), "--version > /dev/null; ls -A out");
    assert_string_equal(said, "index.html\nreport.json\n");
}

static void signal_cancels(void **state)
{
    char said[8192];
    int status = run(said, sizeof(said),
                     "--version > /dev/null; \"$PNB_BUILD_DIR/penumbra\" compare '<a&b>.json' "
                     "--truth-samples 262144 -q -o no & sleep 2; kill -TERM $!; wait $!");
    assert_int_equal(status, 1);
    assert_ptr_equal(strstr(said, "penumbra: error: "), said);
    assert_non_null(strstr(said, "cancelled"));
    assert_false(exists("no"));
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(report_keeps_the_contract),
        TEST(page_is_self_contained),
        TEST(files_of_other_programs_are_judged),
        TEST(mistakes_leave_nothing),
        TEST(entries_have_settings_of_their_own),
        TEST(motion_is_measured),
        TEST(methods_that_cannot_are_found_out_first),
        TEST(full_disk_keeps_the_old_report),
        TEST(signal_cancels),
    };
    return cmocka_run_group_tests_name("compare", tests, NULL, NULL);
}
