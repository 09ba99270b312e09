/* Image files: round trips, other programs' flavours, broken files, disks that are full. */
#define _GNU_SOURCE
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <cmocka.h>

#include <dirent.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <OpenEXR/openexr.h>
#include <spng.h>

#include "image/image.h"

struct fixture {
    pnb_context *context;
    char folder[64];
};

static int set_up(void **state)
{
    struct fixture *f = calloc(1, sizeof(*f));
    strcpy(f->folder, "/tmp/pnb-image-XXXXXX");
    if (!f || !mkdtemp(f->folder) || pnb_context_create(NULL, &f->context) != PNB_OK)
        return -1;
    *state = f;
    return 0;
}

static int file_count(const char *folder)
{
    DIR *dir = opendir(folder);
    int count = -2; /* . and .. */
    while (dir && readdir(dir))
        count++;
    if (dir)
        closedir(dir);
    return count;
}

static int tear_down(void **state)
{
    struct fixture *f = *state;
    char command[128];
    snprintf(command, sizeof(command), "rm -rf '%s'", f->folder);
    int failed = system(command);
    pnb_context_destroy(f->context);
    free(f);
    return failed;
}

static char *in_folder(struct fixture *f, const char *name)
{
    static char path[8][256];
    static int next;
    char *p = path[next++ & 7];
    snprintf(p, 256, "%s/%s", f->folder, name);
    return p;
}

static uint32_t random_u32(uint32_t *seed)
{
    *seed = *seed * 1664525u + 1013904223u;
    return *seed >> 8;
}

/* Values of all sizes, and NaN, infinities, negative zero. */
static pnb_image wild_image(struct fixture *f, int width, int height, int channels)
{
    pnb_image image;
    assert_int_equal(pnb_image_create(f->context, width, height, channels, &image), PNB_OK);
    uint32_t seed = 7;
    size_t count = (size_t)width * (size_t)height * (size_t)channels;
    for (size_t i = 0; i < count; i++) {
        float x = (float)random_u32(&seed) / (1 << 24);
        image.data[i] = i % 17 == 3   ? NAN
                        : i % 17 == 5 ? -x * 1e20f
                        : i % 17 == 7 ? INFINITY
                        : i % 17 == 9 ? -0.0f
                                      : x;
    }
    return image;
}

static void assert_same_floats(const pnb_image *a, const pnb_image *b)
{
    assert_int_equal(a->width, b->width);
    assert_int_equal(a->height, b->height);
    assert_int_equal(a->channels, b->channels);
    size_t count = (size_t)a->width * (size_t)a->height * (size_t)a->channels;
    for (size_t i = 0; i < count; i++) {
        if (isnan(a->data[i]))
            assert_true(isnan(b->data[i]));
        else
            assert_memory_equal(a->data + i, b->data + i, 4);
    }
}

static void float_formats_keep_every_bit(void **state)
{
    struct fixture *f = *state;
    const char *const names[] = {"a.pfm", "a.exr", "A.EXR"};
    const int sizes[][2] = {{1, 1}, {3, 5}, {17, 16}, {64, 33}, {1, 100}, {100, 1}};
    for (int n = 0; n < 3; n++)
        for (int s = 0; s < 6; s++)
            for (int channels = 1; channels <= 3; channels += 2) {
                pnb_image in = wild_image(f, sizes[s][0], sizes[s][1], channels), out;
                char *path = in_folder(f, names[n]);
                assert_int_equal(pnb_image_write(f->context, path, &in), PNB_OK);
                assert_int_equal(pnb_image_read(f->context, path, &out), PNB_OK);
                assert_same_floats(&in, &out);
                pnb_image_finish(f->context, &in);
                pnb_image_finish(f->context, &out);
            }
    assert_int_equal(file_count(f->folder), 3);
}

static void pfm_is_bottom_up_and_both_endian(void **state)
{
    struct fixture *f = *state;
    /* 1 x 2, big-endian: bottom row 1.0, top row 2.0; Windows line ends; bytes to spare. */
    const char big[] = "Pf\r\n1 2\r\n1.0\r\n\x3f\x80\x00\x00\x40\x00\x00\x00rest";
    pnb_image image;
    assert_int_equal(image_decode(f->context, "x", (const uint8_t *)big, sizeof(big) - 1, &image),
                     PNB_OK);
    assert_float_equal(image.data[0], 2, 0);
    assert_float_equal(image.data[1], 1, 0);
    uint8_t *bytes;
    size_t size;
    assert_int_equal(pfm_encode(f->context, &image, &bytes, &size), PNB_OK);
    const char little[] = "Pf\n1 2\n-1.0\n\x00\x00\x80\x3f\x00\x00\x00\x40";
    assert_int_equal(size, sizeof(little) - 1);
    assert_memory_equal(bytes, little, size);
    memory_free(f->context, bytes);
    pnb_image_finish(f->context, &image);
}

static void png_rounds_to_the_nearest_code(void **state)
{
    struct fixture *f = *state;
    /* Each of the 256 codes comes back as itself, and so do values a little beside it. */
    for (int channels = 1; channels <= 3; channels += 2) {
        pnb_image in, out;
        assert_int_equal(pnb_image_create(f->context, 256, 3, channels, &in), PNB_OK);
        for (int y = 0; y < 3; y++)
            for (int x = 0; x < 256; x++)
                for (int c = 0; c < channels; c++)
                    in.data[(y * 256 + x) * channels + c] =
                        (float)linear_from_srgb((x + 0.4 * (y - 1)) / 255);
        char *path = in_folder(f, "a.png");
        assert_int_equal(pnb_image_write(f->context, path, &in), PNB_OK);
        assert_int_equal(pnb_image_read(f->context, path, &out), PNB_OK);
        assert_int_equal(out.channels, channels);
        for (int y = 0; y < 3; y++)
            for (int i = 0; i < 256 * channels; i++)
                assert_float_equal(out.data[y * 256 * channels + i],
                                   linear_from_srgb((double)(i / channels) / 255), 1e-7);
        pnb_image_finish(f->context, &in);
        pnb_image_finish(f->context, &out);
    }
    assert_int_equal(srgb8_from_linear(NAN), 0);
    assert_int_equal(srgb8_from_linear(-INFINITY), 0);
    assert_int_equal(srgb8_from_linear(INFINITY), 255);
    assert_int_equal(srgb8_from_linear(0.2145f), 128);
    assert_float_equal(srgb_from_linear(1), 1, 1e-12);
    for (int i = 0; i <= 1000; i++)
        assert_float_equal(linear_from_srgb(srgb_from_linear(i / 1000.0)), i / 1000.0, 1e-7);
}

/* A PNG as another program might write it. */
static void *make_png(int type, int depth, const void *pixels, size_t size, double gamma,
                      size_t *out_size)
{
    int error;
    spng_ctx *png = spng_ctx_new(SPNG_CTX_ENCODER);
    spng_set_option(png, SPNG_ENCODE_TO_BUFFER, 1);
    struct spng_ihdr head = {
        .width = 2, .height = 1, .bit_depth = (uint8_t)depth, .color_type = (uint8_t)type};
    assert_int_equal(spng_set_ihdr(png, &head), 0);
    struct spng_plte palette = {2, {{255, 0, 128, 0}, {10, 20, 30, 0}}};
    if (type == SPNG_COLOR_TYPE_INDEXED)
        assert_int_equal(spng_set_plte(png, &palette), 0);
    if (gamma > 0)
        assert_int_equal(spng_set_gama(png, gamma), 0);
    assert_int_equal(spng_encode_image(png, pixels, size, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE), 0);
    void *bytes = spng_get_png_buffer(png, out_size, &error);
    spng_ctx_free(png);
    return bytes;
}

static void png_reads_other_kinds(void **state)
{
    struct fixture *f = *state;
    pnb_image image;
    size_t size;
    /* Palette of one bit. */
    const uint8_t indices[] = {0x40}; /* 0, 1 */
    void *png = make_png(SPNG_COLOR_TYPE_INDEXED, 1, indices, 1, 0, &size);
    assert_int_equal(png_decode(f->context, "x", png, size, &image), PNB_OK);
    assert_int_equal(image.channels, 3);
    const double expected[6] = {1, 0, 128 / 255.0, 10 / 255.0, 20 / 255.0, 30 / 255.0};
    for (int i = 0; i < 6; i++)
        assert_float_equal(image.data[i], linear_from_srgb(expected[i]), 1e-7);
    pnb_image_finish(f->context, &image);
    free(png);
    /* Sixteen bits of grey with alpha. */
    const uint16_t wide[] = {1000, 5, 65535, 65535};
    png = make_png(SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 16, wide, 8, 0, &size);
    assert_int_equal(png_decode(f->context, "x", png, size, &image), PNB_OK);
    assert_int_equal(image.channels, 1);
    assert_float_equal(image.data[0], linear_from_srgb(1000 / 65535.0), 1e-7);
    assert_float_equal(image.data[1], 1, 0);
    pnb_image_finish(f->context, &image);
    free(png);
    /* A file that says it is linear. */
    const uint8_t grey[] = {51, 255};
    png = make_png(SPNG_COLOR_TYPE_GRAYSCALE, 8, grey, 2, 1.0, &size);
    assert_int_equal(png_decode(f->context, "x", png, size, &image), PNB_OK);
    assert_float_equal(image.data[0], 0.2, 1e-7);
    pnb_image_finish(f->context, &image);
    free(png);
}

static void exr_keeps_named_channels(void **state)
{
    struct fixture *f = *state;
    enum { W = 19, H = 35 };
    float rgb[W * H * 3], visibility[W * H], depth[W * H];
    for (int i = 0; i < W * H; i++) {
        visibility[i] = i % 5 ? (float)i / (W * H) : NAN;
        depth[i] = (float)i;
        for (int c = 0; c < 3; c++)
            rgb[3 * i + c] = (float)(i + c);
    }
    const pnb_channel channels[] = {{"R", rgb, 3},     {"G", rgb + 1, 3},
                                    {"B", rgb + 2, 3}, {"visibility", visibility, 0},
                                    {"Z", depth, 1},   {"normal.X", rgb, 3}};
    char *path = in_folder(f, "b.exr");
    assert_int_equal(pnb_image_write_exr(f->context, path, W, H, channels, 6), PNB_OK);
    pnb_image image;
    assert_int_equal(pnb_image_read(f->context, path, &image), PNB_OK);
    pnb_image expected = {W, H, 1, visibility};
    assert_same_floats(&expected, &image);
    pnb_image_finish(f->context, &image);
    /* Without visibility: the colours; a layer's colours; nothing that fits. */
    assert_int_equal(pnb_image_write_exr(f->context, path, W, H, channels, 3), PNB_OK);
    assert_int_equal(pnb_image_read(f->context, path, &image), PNB_OK);
    expected = (pnb_image){W, H, 3, rgb};
    assert_same_floats(&expected, &image);
    pnb_image_finish(f->context, &image);
    const pnb_channel layered[] = {{"L.Depth.Z", depth, 0},
                                   {"L.Combined.R", rgb, 3},
                                   {"L.Combined.G", rgb + 1, 3},
                                   {"L.Combined.B", rgb + 2, 3},
                                   {"A.R", depth, 0},
                                   {"A.G", depth, 0},
                                   {"A.B", depth, 0}};
    assert_int_equal(pnb_image_write_exr(f->context, path, W, H, layered, 7), PNB_OK);
    assert_int_equal(pnb_image_read(f->context, path, &image), PNB_OK);
    assert_same_floats(&expected, &image);
    pnb_image_finish(f->context, &image);
    assert_int_equal(pnb_image_write_exr(f->context, path, W, H, layered, 2), PNB_OK);
    assert_int_equal(pnb_image_read(f->context, path, &image), PNB_ERROR_FORMAT);
    /* Refused before anything is written. */
    const pnb_channel twice[] = {{"a", depth, 0}, {"a", depth, 0}};
    assert_int_equal(pnb_image_write_exr(f->context, path, W, H, twice, 2), PNB_ERROR_ARGUMENT);
    assert_int_equal(pnb_image_write_exr(f->context, path, 0, H, channels, 1), PNB_ERROR_ARGUMENT);
}

/* An EXR of the given storage and pixel type with channel "v" = 1, 2, 3 ...; 40 x 37. */
static void write_foreign_exr(const char *path, exr_storage_t storage, exr_pixel_type_t type,
                              exr_compression_t compression)
{
    enum { W = 40, H = 37, TILE = 16 };
    static float data[W * H];
    exr_context_t exr = NULL;
    int part;
    for (int i = 0; i < W * H; i++)
        data[i] = (float)(i + 1);
    assert_int_equal(exr_start_write(&exr, path, EXR_WRITE_FILE_DIRECTLY, NULL), 0);
    assert_int_equal(exr_add_part(exr, NULL, storage, &part), 0);
    /* A data window away from the origin. */
    exr_attr_box2i_t window;
    window.min.x = -3, window.min.y = 5;
    window.max.x = -3 + W - 1, window.max.y = 5 + H - 1;
    exr_attr_v2f_t center;
    center.x = center.y = 0;
    assert_int_equal(exr_initialize_required_attr(exr, part, &window, &window, 1, &center, 1,
                                                  EXR_LINEORDER_INCREASING_Y, compression),
                     0);
    if (storage == EXR_STORAGE_TILED)
        assert_int_equal(
            exr_set_tile_descriptor(exr, part, TILE, TILE, EXR_TILE_ONE_LEVEL, EXR_TILE_ROUND_DOWN),
            0);
    assert_int_equal(exr_add_channel(exr, part, "v", type, EXR_PERCEPTUALLY_LOGARITHMIC, 1, 1), 0);
    assert_int_equal(exr_write_header(exr), 0);
    exr_encode_pipeline_t pipe = EXR_ENCODE_PIPELINE_INITIALIZER;
    int32_t lines = TILE;
    bool tiled = storage == EXR_STORAGE_TILED, first = true;
    if (!tiled)
        exr_get_scanlines_per_chunk(exr, part, &lines);
    for (int y = 0; y < H; y += lines)
        for (int x = 0; x < W; x += tiled ? TILE : W) {
            exr_chunk_info_t chunk;
            assert_int_equal(
                tiled ? exr_write_tile_chunk_info(exr, 0, x / TILE, y / TILE, 0, 0, &chunk)
                      : exr_write_scanline_chunk_info(exr, 0, 5 + y, &chunk),
                0);
            assert_int_equal(first ? exr_encoding_initialize(exr, 0, &chunk, &pipe)
                                   : exr_encoding_update(exr, 0, &chunk, &pipe),
                             0);
            pipe.channels[0].user_data_type = EXR_PIXEL_FLOAT;
            pipe.channels[0].user_bytes_per_element = 4;
            pipe.channels[0].user_pixel_stride = 4;
            pipe.channels[0].user_line_stride = 4 * W;
            pipe.channels[0].encode_from_ptr = (const uint8_t *)(data + y * W + x);
            if (first)
                assert_int_equal(exr_encoding_choose_default_routines(exr, 0, &pipe), 0);
            assert_int_equal(exr_encoding_run(exr, 0, &pipe), 0);
            first = false;
        }
    exr_encoding_destroy(exr, &pipe);
    assert_int_equal(exr_finish(&exr), 0);
}

static void exr_reads_other_kinds(void **state)
{
    struct fixture *f = *state;
    char *path = in_folder(f, "foreign.exr");
    const exr_compression_t compressions[] = {EXR_COMPRESSION_NONE, EXR_COMPRESSION_RLE,
                                              EXR_COMPRESSION_ZIPS, EXR_COMPRESSION_ZIP,
                                              EXR_COMPRESSION_PIZ};
    const exr_pixel_type_t types[] = {EXR_PIXEL_FLOAT, EXR_PIXEL_HALF, EXR_PIXEL_UINT};
    for (int tiled = 0; tiled < 2; tiled++)
        for (int t = 0; t < 3; t++)
            for (int c = 0; c < 5; c++) {
                write_foreign_exr(path, tiled ? EXR_STORAGE_TILED : EXR_STORAGE_SCANLINE, types[t],
                                  compressions[c]);
                pnb_image image;
                pnb_status status = pnb_image_read(f->context, path, &image);
                if (status != PNB_OK)
                    print_error("%s\n", pnb_context_error(f->context));
                assert_int_equal(status, PNB_OK);
                assert_int_equal(image.width, 40);
                assert_int_equal(image.height, 37);
                for (int i = 0; i < 40 * 37; i++)
                    assert_float_equal(image.data[i], i + 1, 0);
                pnb_image_finish(f->context, &image);
            }
}

static void assert_fails_in_one_line(struct fixture *f, pnb_status status, const char *path)
{
    const char *text = pnb_context_error(f->context);
    assert_int_not_equal(status, PNB_OK);
    assert_non_null(strstr(text, path));
    assert_null(strchr(text, '\n'));
}

static void broken_files_end_in_an_error(void **state)
{
    struct fixture *f = *state;
    const char *const names[] = {"t.png", "t.exr", "t.pfm"};
    pnb_image image = wild_image(f, 20, 18, 3), out;
    for (int n = 0; n < 3; n++) {
        char *path = in_folder(f, names[n]);
        uint8_t *bytes;
        size_t size;
        assert_int_equal(pnb_image_write(f->context, path, &image), PNB_OK);
        assert_int_equal(file_read(f->context, path, SIZE_MAX, NULL, &bytes, &size), PNB_OK);
        /* Every truncation: copied so that the sanitizer sees a read past the end. */
        for (size_t k = 0; k < size; k += k < 400 ? 1 : 37) {
            uint8_t *cut = malloc(k ? k : 1);
            memcpy(cut, bytes, k);
            pnb_status status = image_decode(f->context, "cut", cut, k, &out);
            /* PNG: all pixels may be there before the end mark. */
            if (status == PNB_OK) {
                assert_true(n == 0 && k + 40 > size);
                pnb_image_finish(f->context, &out);
            } else {
                assert_fails_in_one_line(f, status, "cut");
            }
            free(cut);
        }
        /* Changed bytes: any answer but a crash. */
        uint32_t seed = 99;
        uint8_t *changed = malloc(size);
        for (int round = 0; round < 1500; round++) {
            memcpy(changed, bytes, size);
            size_t head = round % 2 && size > 400 ? 400 : size;
            for (uint32_t k = random_u32(&seed) % 4 + 1; k > 0; k--)
                changed[random_u32(&seed) % head] = (uint8_t)random_u32(&seed);
            if (image_decode(f->context, "changed", changed, size, &out) == PNB_OK)
                pnb_image_finish(f->context, &out);
        }
        free(changed);
        memory_free(f->context, bytes);
    }
    pnb_image_finish(f->context, &image);
}

static void huge_headers_are_refused(void **state)
{
    struct fixture *f = *state;
    pnb_image out;
    const char *const heads[] = {"PF\n2000000000 2000000000\n-1\n12345678",
                                 "PF\n16384 16384\n-1\n12345678",
                                 "Pf\n99999999999999999999 1\n-1\n12345678",
                                 "Pf\n-4 1\n-1\n12345678",
                                 "Pf\n4 0\n-1\n12345678",
                                 "Pf\n1 1\nnan\n12345678",
                                 "Pf\n1 1\n0\n12345678",
                                 "Pf",
                                 "P",
                                 "",
                                 "not an image at all",
                                 "PFM 1 1 -1 12345678"};
    for (size_t i = 0; i < sizeof(heads) / sizeof(heads[0]); i++)
        assert_fails_in_one_line(
            f, image_decode(f->context, "head", (const uint8_t *)heads[i], strlen(heads[i]), &out),
            "head");
    /* A PNG of 60000 x 60000 in 60 bytes. */
    const uint8_t png[] = {0x89, 'P',  'N', 'G', '\r', '\n', 0x1a, '\n', 0,    0, 0,
                           13,   'I',  'H', 'D', 'R',  0,    0,    0xea, 0x60, 0, 0,
                           0xea, 0x60, 8,   2,   0,    0,    0,    0,    0,    0, 0};
    assert_fails_in_one_line(f, image_decode(f->context, "png", png, sizeof(png), &out), "png");
    assert_int_equal(pnb_image_create(f->context, 1 << 20, 1 << 20, 1, &out), PNB_ERROR_FORMAT);
    assert_int_equal(pnb_image_create(f->context, 0, 1, 1, &out), PNB_ERROR_ARGUMENT);
    assert_int_equal(pnb_image_create(f->context, 1, 1, 2, &out), PNB_ERROR_ARGUMENT);
}

static void files_that_cannot_be_read(void **state)
{
    struct fixture *f = *state;
    pnb_image out;
    const char *const paths[] = {in_folder(f, "missing.png"), f->folder, "/dev/null", "/dev/zero"};
    for (int i = 0; i < 4; i++)
        assert_fails_in_one_line(f, pnb_image_read(f->context, paths[i], &out), paths[i]);
    assert_int_equal(file_count(f->folder), 0);
}

static void files_that_cannot_be_written(void **state)
{
    struct fixture *f = *state;
    pnb_image image = wild_image(f, 30, 30, 3);
    char *file = in_folder(f, "plain");
    assert_int_equal(pnb_file_write(f->context, file, "x", 1), PNB_OK);
    mkdir(in_folder(f, "folder.png"), 0777);
    int before = file_count(f->folder);
    char long_name[400];
    memset(long_name, 'a', 300);
    strcpy(long_name + 300, ".png");
    char long_path[600];
    snprintf(long_path, sizeof(long_path), "%s/%s", f->folder, long_name);
    const char *const paths[] = {in_folder(f, "no/such/folder.png"),
                                 in_folder(f, "plain/x.png"),
                                 in_folder(f, "folder.png"),
                                 in_folder(f, "a.jpeg"),
                                 in_folder(f, "png"),
                                 long_path,
                                 "/dev/full",
                                 ""};
    for (size_t i = 0; i < sizeof(paths) / sizeof(paths[0]); i++)
        assert_fails_in_one_line(f, pnb_image_write(f->context, paths[i], &image), paths[i]);
    assert_int_equal(file_count(f->folder), before);
    assert_int_equal(pnb_image_write(f->context, "/dev/null", &image), PNB_OK);
    if (geteuid() != 0) { /* root writes everywhere */
        chmod(f->folder, 0555);
        char *path = in_folder(f, "x.png");
        assert_fails_in_one_line(f, pnb_image_write(f->context, path, &image), path);
        chmod(f->folder, 0755);
    }
    pnb_image_finish(f->context, &image);
}

/* A limit on file size stands for the disk that is full after some bytes. The old file stays. */
static void full_disk_leaves_the_old_file(void **state)
{
    struct fixture *f = *state;
    pnb_image image = wild_image(f, 200, 200, 3);
    struct rlimit old;
    getrlimit(RLIMIT_FSIZE, &old);
    const char *const names[] = {"d.png", "d.exr", "d.pfm"};
    for (int n = 0; n < 3; n++) {
        char *path = in_folder(f, names[n]);
        assert_int_equal(pnb_file_write(f->context, path, "old", 3), PNB_OK);
        setrlimit(RLIMIT_FSIZE, &(struct rlimit){10000, old.rlim_max});
        pnb_status status = pnb_image_write(f->context, path, &image);
        setrlimit(RLIMIT_FSIZE, &old);
        assert_int_equal(status, PNB_ERROR_FILE);
        assert_fails_in_one_line(f, status, path);
        uint8_t *bytes;
        size_t size;
        assert_int_equal(file_read(f->context, path, 100, NULL, &bytes, &size), PNB_OK);
        assert_int_equal(size, 3);
        memory_free(f->context, bytes);
    }
    assert_int_equal(file_count(f->folder), 3);
    pnb_image_finish(f->context, &image);
}

static void closed_pipe_is_an_error(void **state)
{
    struct fixture *f = *state;
    int ends[2];
    assert_int_equal(pipe(ends), 0);
    close(ends[0]);
    char path[64];
    snprintf(path, sizeof(path), "/dev/fd/%d", ends[1]);
    pnb_image image = wild_image(f, 20, 20, 1);
    assert_int_equal(pnb_image_write(f->context, path, &image), PNB_ERROR_FILE);
    close(ends[1]);
    pnb_image_finish(f->context, &image);
}

static void writing_keeps_mode_and_links(void **state)
{
    struct fixture *f = *state;
    char *target = in_folder(f, "target"), *link = in_folder(f, "link");
    assert_int_equal(pnb_file_write(f->context, target, "1", 1), PNB_OK);
    chmod(target, 0640);
    assert_int_equal(symlink("target", link), 0);
    assert_int_equal(pnb_file_write(f->context, link, "22", 2), PNB_OK);
    struct stat info;
    assert_int_equal(lstat(link, &info), 0);
    assert_true(S_ISLNK(info.st_mode));
    assert_int_equal(stat(target, &info), 0);
    assert_int_equal(info.st_size, 2);
    assert_int_equal(info.st_mode & 0777, 0640);
    assert_int_equal(file_count(f->folder), 2);
}

/* As small as files get for their pixels: nothing that is whole may be taken for broken. */
static void flat_images_are_believed(void **state)
{
    struct fixture *f = *state;
    const char *const names[] = {"flat.png", "flat.exr", "flat.pfm"};
    pnb_image image, out;
    assert_int_equal(pnb_image_create(f->context, 3000, 2000, 1, &image), PNB_OK);
    for (int n = 0; n < 3; n++) {
        char *path = in_folder(f, names[n]);
        assert_int_equal(pnb_image_write(f->context, path, &image), PNB_OK);
        assert_int_equal(pnb_image_read(f->context, path, &out), PNB_OK);
        assert_same_floats(&image, &out);
        pnb_image_finish(f->context, &out);
    }
    pnb_image_finish(f->context, &image);
}

/* An allocator that has no memory left after some calls. */
struct scarce {
    int left;
    long blocks;
};

static void *scarce_reallocate(void *user, void *old, size_t size)
{
    struct scarce *scarce = user;
    if (size == 0) {
        scarce->blocks--;
        free(old);
        return NULL;
    }
    if (scarce->left-- <= 0)
        return NULL;
    void *block = realloc(old, size);
    if (block && !old)
        scarce->blocks++;
    return block;
}

static void scarce_memory_is_an_error(void **state)
{
    struct fixture *f = *state;
    const char *const names[] = {"s.png", "s.exr", "s.pfm"};
    pnb_image image = wild_image(f, 40, 30, 3), out;
    for (int n = 0; n < 3; n++) {
        char *path = in_folder(f, names[n]);
        assert_int_equal(pnb_image_write(f->context, path, &image), PNB_OK);
        bool wrote = false, read = false;
        for (int left = 1; left < 200 && !(wrote && read); left++) {
            struct scarce scarce = {left, 0};
            pnb_context *context;
            assert_int_equal(pnb_context_create(&(pnb_context_desc){.reallocate = scarce_reallocate,
                                                                    .user = &scarce},
                                                &context),
                             PNB_OK);
            pnb_status status = pnb_image_write(context, path, &image);
            wrote = status == PNB_OK;
            assert_true(wrote || status == PNB_ERROR_MEMORY);
            scarce.left = left;
            status = pnb_image_read(context, path, &out);
            read = status == PNB_OK;
            assert_true(read || status == PNB_ERROR_MEMORY);
            pnb_image_finish(context, &out);
            pnb_context_destroy(context);
            assert_int_equal(scarce.blocks, 0); /* nothing is lost on the way out */
        }
        assert_true(wrote && read);
    }
    assert_int_equal(file_count(f->folder), 3);
    pnb_image_finish(f->context, &image);
}

/* Lab from linear RGB, the other way round, from Ottosson's text. */
static void oklab_from_linear(const double rgb[3], double lab[3])
{
    double l = cbrt(0.4122214708 * rgb[0] + 0.5363325363 * rgb[1] + 0.0514459929 * rgb[2]);
    double m = cbrt(0.2119034982 * rgb[0] + 0.6806995451 * rgb[1] + 0.1073969566 * rgb[2]);
    double s = cbrt(0.0883024619 * rgb[0] + 0.2817188376 * rgb[1] + 0.6299787005 * rgb[2]);
    lab[0] = 0.2104542553 * l + 0.7936177850 * m - 0.0040720468 * s;
    lab[1] = 1.9779984951 * l - 2.4285922050 * m + 0.4505937099 * s;
    lab[2] = 0.0259040371 * l + 0.7827717662 * m - 0.8086757660 * s;
}

static void colormaps_step_evenly(void **state)
{
    void (*const maps[])(double, double *) = {pnb_colormap_sequential, pnb_colormap_diverging};
    const int steps[] = {32, 64};
    for (int m = 0; m < 2; m++) {
        double shortest = 1, longest = 0, last[3];
        for (int i = 0; i <= steps[m]; i++) {
            double rgb[3], lab[3], d = 0;
            maps[m]((double)i / steps[m], rgb);
            oklab_from_linear(rgb, lab);
            for (int k = 0; k < 3 && i > 0; k++)
                d += (lab[k] - last[k]) * (lab[k] - last[k]);
            if (i > 0) {
                shortest = fmin(shortest, sqrt(d));
                longest = fmax(longest, sqrt(d));
                if (m == 0)
                    assert_true(lab[0] > last[0] + 0.01); /* lightness rises all along */
            }
            memcpy(last, lab, sizeof(last));
        }
        assert_true(longest < 1.01 * shortest);
    }
    double a[3], b[3];
    pnb_colormap_diverging(0.5, a);
    assert_float_equal(a[0], a[2], 1e-6);
    pnb_colormap_diverging(0, a);
    pnb_colormap_diverging(-1e30, b);
    assert_memory_equal(a, b, sizeof(a));
    assert_true(a[2] > a[0]);
    pnb_colormap_diverging(INFINITY, b);
    assert_true(b[0] > b[2]);
}

static void error_map_shows_signs(void **state)
{
    struct fixture *f = *state;
    enum { W = 220, H = 30 };
    float error[W * H];
    for (int i = 0; i < W * H; i++)
        error[i] = i % W == 0 ? NAN : ((float)(i % W) / W - 0.5f) * 0.2f;
    pnb_image map;
    assert_int_equal(pnb_image_error_map(f->context, error, W, H, 0.05, true, &map), PNB_OK);
    assert_int_equal(map.width, W);
    assert_true(map.height > H);
    assert_true(map.data[0] == map.data[2] && map.data[0] < 0.1f);
    assert_true(map.data[3 * 5 + 2] > map.data[3 * 5]);             /* too dark: blue */
    assert_true(map.data[3 * (W - 2)] > map.data[3 * (W - 2) + 2]); /* too light: red */
    const char *keep = getenv("PNB_TEST_PICTURES");
    if (keep) {
        char path[300];
        snprintf(path, sizeof(path), "%s/error-map.png", keep);
        assert_int_equal(pnb_image_write(f->context, path, &map), PNB_OK);
    }
    pnb_image_finish(f->context, &map);
    assert_int_equal(pnb_image_error_map(f->context, error, W, H, 0.05, false, &map), PNB_OK);
    assert_int_equal(map.height, H);
    pnb_image_finish(f->context, &map);
    assert_int_equal(pnb_image_error_map(f->context, error, 3, 2, 0.05, true, &map), PNB_OK);
    pnb_image_finish(f->context, &map);
    assert_int_equal(pnb_image_error_map(f->context, error, W, H, 0, true, &map),
                     PNB_ERROR_ARGUMENT);
}

#define TEST(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void)
{
    const struct CMUnitTest tests[] = {
        TEST(float_formats_keep_every_bit),   TEST(pfm_is_bottom_up_and_both_endian),
        TEST(png_rounds_to_the_nearest_code), TEST(png_reads_other_kinds),
        TEST(exr_keeps_named_channels),       TEST(exr_reads_other_kinds),
        TEST(broken_files_end_in_an_error),   TEST(huge_headers_are_refused),
        TEST(files_that_cannot_be_read),      TEST(files_that_cannot_be_written),
        TEST(full_disk_leaves_the_old_file),  TEST(closed_pipe_is_an_error),
        TEST(writing_keeps_mode_and_links),   TEST(scarce_memory_is_an_error),
        TEST(flat_images_are_believed),       TEST(colormaps_step_evenly),
        TEST(error_map_shows_signs),
    };
    return cmocka_run_group_tests_name("image", tests, NULL, NULL);
}
