/* method/wedge/wedge.c: penumbra wedges and their blending, three variants.
 *
 * Forest, Barthe, Paulin: Realistic Soft Shadows by Penumbra-Wedges Blending (2006), on what
 * Akenine-Moeller and Assarsson had before (2002, 2003). Rectangular lights; any receivers.
 *
 *   wedge                one sum for all silhouettes: what overlaps is counted twice
 *   wedge-probabilistic  product of the silhouettes' visibilities
 *   wedge-blend          per silhouette and cell of the light the hidden area and where it is;
 *                        what two silhouettes hide together is estimated from that (section 3.2)
 *
 * A frame, all on the device:
 *
 *   setup    edges and faces into light space, cut at the light's plane
 *   groups   boxes of 32 of them;  tiles: boxes of the receivers of 16 x 16 pixels
 *   masks    which parts, which groups and which items may hide light from a tile
 *   wedge    per fragment: part after part, its wedges, then the blending
 *
 * Differs from the paper: README.md. The sums need no shadow volume underneath: an edge adds the
 * area between it and the light's left border, wherever it is seen, instead of the area between it
 * and the light's middle on top of a volume's 0 or 1. So nothing depends on two comparisons that
 * must agree, which is where streaks come from; silhouette and final buffers are registers.
 *
 * Cost: O(items + tiles x groups + fragments x wedges that reach their tile). Invariants: V in
 * [0,1]; continuous in the receiver but for `wedge`, whose middle is hidden or not. Open and
 * non-manifold parts count layers (warned of): two layers that hide the same count twice in a
 * silhouette.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "method/opengl.h"
#include "method/wedge/cells.h"
#include "method/wedge/tables.h"

static bool is(const pnb_solver *solver, const char *key, const char *word)
{
    return strcmp(solver_param(solver, key), word) == 0;
}

static bool blends(const pnb_solver *solver)
{
    return strcmp(solver->method->info.name, "wedge-blend") == 0;
}

static void make(pnb_status *status, struct wedge_room *room, const char *fragment,
                 const char *defines, struct gl_program **program)
{
    struct gl_program_desc desc = {
        .vertex = "gl/cover.vert", .fragment = fragment, .defines = defines};
    gl_program_destroy(*program);
    *program = NULL;
    if (*status == PNB_OK)
        *status = gl_program_create(room->device, &desc, program);
}

/* Cells that are no grid over a rectangle: between lines, row by row. */
static bool has_lines(const pnb_solver *solver, const struct wedge_light *light)
{
    return !light->rectangle || (blends(solver) && is(solver, "parts", "8"));
}

/* Cells of the light; a `wedge` that does not blend has one. */
static int part_count(const pnb_solver *solver)
{
    return blends(solver) ? atoi(solver_param(solver, "parts")) : 1;
}

/* What depends on how silhouettes are found, and on the light: line_rows is a light's rows of cells
 * between lines, or 0 for a rectangle's grid. */
static pnb_status make_sums(pnb_solver *solver, struct wedge_room *room, enum wedge_search search,
                            int line_rows)
{
    bool center = search == WEDGE_SEARCH_CENTER;
    char setup[32], wedge[256];
    int cells = part_count(solver);
    bool gravity = blends(solver) && (is(solver, "overlap", "gravity") || line_rows > 0);
    snprintf(setup, sizeof(setup), "#define CENTER %d\n", center);
    snprintf(wedge, sizeof(wedge),
             "#define COLUMNS %d\n#define ROWS %d\n#define BLEND %d\n#define GRAVITY %d\n"
             "#define MIDDLE %d\n#define CENTER %d\n#define TRIES %d\n#define LINE_ROWS %d\n",
             cells >= 8   ? 4
             : cells == 4 ? 2
                          : 1,
             cells == 16  ? 4
             : cells >= 4 ? 2
                          : 1,
             blends(solver), gravity, strcmp(solver->method->info.name, "wedge") == 0, center,
             search == WEDGE_SEARCH_QUICK ? 1 : 4, line_rows);
    pnb_status status = PNB_OK;
    make(&status, room, "method/wedge/setup.frag", setup, &room->programs.setup);
    make(&status, room, "method/wedge/wedge.frag", wedge, &room->programs.wedge);
    room->search = search;
    room->line_rows = status == PNB_OK ? line_rows : -1; /* else they are made again */
    if (blends(solver) && !gravity != is(solver, "overlap", "rectangle"))
        solver_warn(solver, "overlap=rectangle is for the cells of a rectangle's grid: "
                            "overlap=gravity is taken");
    return status;
}

static pnb_status make_programs(pnb_solver *solver, struct wedge_room *room)
{
    struct wedge_programs *p = &room->programs;
    pnb_status status = PNB_OK;
    make(&status, room, "method/wedge/groups.frag", NULL, &p->groups);
    make(&status, room, "method/wedge/tiles.frag", NULL, &p->tiles);
    make(&status, room, "method/wedge/coarse.frag", NULL, &p->coarse);
    make(&status, room, "method/wedge/part_mask.frag", NULL, &p->part_mask);
    make(&status, room, "method/wedge/hits.frag", NULL, &p->hits);
    make(&status, room, "method/wedge/prefix.frag", NULL, &p->prefix);
    make(&status, room, "method/wedge/list.frag", NULL, &p->list);
    make(&status, room, "method/wedge/item_mask.frag", NULL, &p->mask);
    enum wedge_search search =
        is(solver, "silhouettes", "center") ? WEDGE_SEARCH_CENTER : WEDGE_SEARCH_QUICK;
    return status == PNB_OK ? make_sums(solver, room, search, 0) : status;
}

static pnb_status wedge_changed(pnb_solver *solver, struct opengl_state *state)
{
    struct wedge_room *room = state->room;
    struct wedge_parts *parts;
    pnb_status status = wedge_parts_create(solver->scene, state->occluders, &parts);
    if (status != PNB_OK)
        return status;
    wedge_parts_destroy(room->parts);
    room->parts = parts;
    if (parts->open_count > 0)
        solver_warn(solver,
                    "%zu edges without a partner of opposite direction: their parts count every "
                    "layer, so what two layers hide counts twice",
                    parts->open_count);
    return wedge_tables_upload(room);
}

static pnb_status wedge_create(pnb_solver *solver, struct opengl_state *state)
{
    struct wedge_room *room = state->room = memory_calloc(solver->context, 1, sizeof(*room));
    if (!room)
        return status_no_memory(solver->context, sizeof(*room));
    room->device = state->device;
    room->tile_wanted = solver_param_integer(solver, "tile");
    pnb_status status = wedge_changed(solver, state);
    return status == PNB_OK ? make_programs(solver, room) : status;
}

static void wedge_destroy(pnb_solver *solver, struct opengl_state *state)
{
    struct wedge_room *room = state->room;
    if (!room)
        return;
    wedge_tables_finish(room);
    const struct wedge_programs *p = &room->programs;
    struct gl_program *programs[] = {p->setup, p->groups, p->tiles, p->coarse, p->part_mask,
                                     p->hits,  p->prefix, p->list,  p->mask,   p->wedge};
    for (size_t i = 0; i < sizeof(programs) / sizeof(*programs); i++)
        gl_program_destroy(programs[i]);
    wedge_parts_destroy(room->parts);
    memory_free(solver->context, room);
    state->room = NULL;
}

/* Uniforms one after another; the rest of the draw is filled in by the passes. */
struct pass {
    struct gl_draw draw;
    int count;
};

static void give(struct pass *pass, struct gl_uniform uniform)
{
    pass->draw.uniforms[pass->count++] = uniform;
}

static void give_vector(struct pass *pass, const char *name, vec3 v)
{
    give(pass, gl_vec3(name, (const double[]){v.x, v.y, v.z}));
}

static void give_light(struct pass *pass, const struct wedge_light *light)
{
    give_vector(pass, "light_center", light->center);
    give_vector(pass, "light_x_axis", light->x_axis);
    give_vector(pass, "light_y_axis", light->y_axis);
    give_vector(pass, "light_half_u", light->half_u);
    give_vector(pass, "light_half_v", light->half_v);
    give_vector(pass, "light_normal", light->normal);
    give(pass, gl_float("light_gap", light->gap));
}

static void give_receivers(struct pass *pass, const struct gl_frame *frame)
{
    give(pass, gl_sampler("frame_position", frame->position));
    give(pass, gl_sampler("frame_normal", frame->normal));
}

static void cover(struct wedge_room *room, struct pass *pass, struct gl_program *program,
                  struct gl_target *target)
{
    pass->draw.program = program;
    pass->draw.target = target;
    gl_draw_cover(room->device, &pass->draw);
}

static void give_two(struct pass *pass, const char *first, const char *second,
                     struct gl_texture *const *textures)
{
    give(pass, gl_sampler(first, textures[0]));
    give(pass, gl_sampler(second, textures[1]));
}

static void give_table(struct pass *pass, const char *name, const struct wedge_table *table)
{
    give(pass, gl_sampler(name, table->textures[0]));
}

static void give_items(struct pass *pass, const struct wedge_room *room, int count)
{
    static const char *const names[4] = {"item_a", "item_b", "item_c", "item_d"};
    for (int k = 0; k < count; k++)
        give(pass, gl_sampler(names[k], room->items.textures[k]));
}

static void give_groups(struct pass *pass, const struct wedge_room *room)
{
    give_two(pass, "group_low", "group_high", room->group_box.textures);
    give_two(pass, "group_least", "group_most", room->group_box.textures + 2);
}

/* Where a coarse tile's list is. */
static void give_list(struct pass *pass, const struct wedge_room *room)
{
    give_table(pass, "list", &room->list);
    give_table(pass, "prefix", &room->prefix);
    give(pass, gl_int("coarse", room->coarse));
    give(pass, gl_int("coarse_columns", room->coarse_columns));
    give(pass, gl_int("word_count", room->words));
    give(pass, gl_int("list_width", room->list_width));
    give(pass, gl_int("list_rows", room->list_rows));
}

/* Items into light space, and the boxes of their groups. */
static void draw_setup(struct wedge_room *room, const struct wedge_light *light)
{
    struct pass setup = {0}, groups = {0};
    static const char *const names[5] = {"item_a", "item_b", "item_c", "item_first", "item_second"};
    give_light(&setup, light);
    for (int k = 0; k < 5; k++)
        give(&setup, gl_sampler(names[k], room->in[k]));
    cover(room, &setup, room->programs.setup, room->items.target);
    give_items(&groups, room, 4);
    give(&groups, gl_sampler("group_info", room->group_info));
    give(&groups, gl_int("group_count", (int)room->parts->group_count));
    cover(room, &groups, room->programs.groups, room->group_box.target);
}

/* The boxes of the receivers of tiles and of coarse tiles. */
static void draw_tiles(struct wedge_room *room, const struct wedge_light *light,
                       const struct gl_frame *frame)
{
    struct pass tiles = {0}, coarse = {0};
    give_light(&tiles, light);
    give_receivers(&tiles, frame);
    struct gl_uniform size = {
        .name = "frame_size", .type = GL_UNIFORM_IVEC2, .integer = {frame->width, frame->height}};
    give(&tiles, size);
    give(&tiles, gl_int("tile_size", room->tile_size));
    cover(room, &tiles, room->programs.tiles, room->tile_box.target);
    struct gl_uniform count = {.name = "tile_count",
                               .type = GL_UNIFORM_IVEC2,
                               .integer = {room->tile_columns, room->tile_rows}};
    give_two(&coarse, "tile_low", "tile_high", room->tile_box.textures);
    give(&coarse, count);
    give(&coarse, gl_int("coarse", room->coarse));
    cover(room, &coarse, room->programs.coarse, room->coarse_box.target);
}

/* Which parts and which groups matter to a coarse tile, and its list of groups. */
static void draw_lists(struct wedge_room *room, const struct wedge_light *light)
{
    struct pass parts = {0}, hits = {0}, prefix = {0}, list = {0};
    give_two(&parts, "tile_low", "tile_high", room->coarse_box.textures);
    give_two(&parts, "part_low", "part_high", room->part_box);
    give(&parts, gl_int("tile_columns", room->coarse_columns));
    give(&parts, gl_int("part_count", (int)room->parts->part_count));
    give(&parts, gl_float("light_gap", light->gap));
    cover(room, &parts, room->programs.part_mask, room->part_mask.target);

    give_two(&hits, "tile_low", "tile_high", room->coarse_box.textures);
    give_groups(&hits, room);
    give(&hits, gl_sampler("group_info", room->group_info));
    give_table(&hits, "part_mask", &room->part_mask);
    give(&hits, gl_int("tile_columns", room->coarse_columns));
    give(&hits, gl_int("group_count", (int)room->parts->group_count));
    cover(room, &hits, room->programs.hits, room->hits.target);

    give_table(&prefix, "hits", &room->hits);
    cover(room, &prefix, room->programs.prefix, room->prefix.target);

    give_table(&list, "hits", &room->hits);
    give_table(&list, "prefix", &room->prefix);
    give(&list, gl_int("word_count", room->words));
    give(&list, gl_int("list_width", room->list_width));
    give(&list, gl_int("list_rows", room->list_rows));
    cover(room, &list, room->programs.list, room->list.target);
}

/* Which items of the listed groups matter to a tile. */
static void draw_masks(struct wedge_room *room)
{
    struct pass mask = {0};
    give_items(&mask, room, 4);
    give_groups(&mask, room);
    give_two(&mask, "tile_low", "tile_high", room->tile_box.textures);
    give_list(&mask, room);
    give(&mask, gl_sampler("group_info", room->group_info));
    give_two(&mask, "part_low", "part_high", room->part_box);
    give(&mask, gl_int("tile_columns", room->tile_columns));
    cover(room, &mask, room->programs.mask, room->mask.target);
}

/* A light's cells as the shader has them, each array of vec4. */
struct line_uniforms {
    float rows[5][WEDGE_ROWS_MAX + 4][4]; /* span, left at low and high, right at low and high */
    float cells[5][WEDGE_BINS_MAX][4];    /* x, y, width, height, share of the bounds */
    float bin_end[4];
    double area;
};

static void fill_lines(const struct wedge_cells *cells, struct line_uniforms *lines)
{
    memset(lines, 0, sizeof(*lines));
    lines->area = cells->area;
    for (int r = 0; r < WEDGE_ROWS_MAX + 4; r++)
        lines->rows[0][r][0] = lines->rows[0][r][1] = 1e30f;
    for (int r = 0; r < cells->row_count; r++) {
        const struct wedge_row *row = &cells->rows[r];
        lines->rows[0][r][0] = (float)row->low;
        lines->rows[0][r][1] = (float)row->high;
        lines->rows[0][r][2] = (float)(1 / (row->high - row->low));
        for (int c = 0; c < cells->columns; c++)
            for (int end = 0; end < 2; end++) {
                lines->rows[1 + end][r][c] = (float)row->left[end][c];
                lines->rows[3 + end][r][c] = (float)row->right[end][c];
            }
        lines->bin_end[row->bin] = (float)(r + 1);
    }
    for (int j = 0; j < cells->bins; j++)
        for (int c = 0; c < cells->columns; c++) {
            const struct wedge_cell *cell = &cells->cells[j][c];
            double width = cell->x1 - cell->x0, height = cell->y1 - cell->y0;
            double bounds = width * height;
            lines->cells[0][j][c] = (float)cell->x0;
            lines->cells[1][j][c] = (float)cell->y0;
            lines->cells[2][j][c] = (float)width;
            lines->cells[3][j][c] = (float)height;
            lines->cells[4][j][c] = (float)(bounds > 0 ? cell->area / bounds : 0);
        }
    /* A bin without rows ends where the one before it does. */
    for (int j = 1; j < 4; j++)
        lines->bin_end[j] = fmaxf(lines->bin_end[j], lines->bin_end[j - 1]);
}

static void give_lines(struct pass *pass, const struct line_uniforms *lines, int rows, int bins)
{
    static const char *const row_names[5] = {"row_span", "left_low", "left_high", "right_low",
                                             "right_high"};
    static const char *const cell_names[5] = {"cell_x", "cell_y", "cell_width", "cell_height",
                                              "cell_area"};
    for (int k = 0; k < 5; k++)
        give(pass, gl_floats(row_names[k], GL_UNIFORM_VEC4, lines->rows[k][0], rows));
    for (int k = 0; k < 5; k++)
        give(pass, gl_floats(cell_names[k], GL_UNIFORM_VEC4, lines->cells[k][0], bins));
    give(pass, gl_floats("bin_end", GL_UNIFORM_VEC4, lines->bin_end, 1));
    give(pass, gl_float("light_area", lines->area));
}

/* A frame's lights, and what is drawn of them. */
struct work {
    pnb_solver *solver;
    struct wedge_room *room;
    const struct gl_frame *frame;
    struct wedge_light *lights; /* convex pieces */
    size_t light_count;
    struct gl_target *target;
    struct gl_texture *visibility;
};

/* marks: pixels whose loops the device ended are to show it (CUT in wedge.frag). */
static void draw_wedges(const struct work *work, const struct wedge_light *light, bool marks)
{
    struct wedge_room *room = work->room;
    struct pass pass = {0};
    struct line_uniforms lines;
    give_light(&pass, light);
    give_receivers(&pass, work->frame);
    give_items(&pass, room, 4);
    give_list(&pass, room);
    give(&pass, gl_sampler("group_info", room->group_info));
    give_two(&pass, "part_low", "part_high", room->part_box);
    give_two(&pass, "group_low", "group_high", room->group_box.textures);
    give_table(&pass, "item_mask", &room->mask);
    give(&pass, gl_int("tile_size", room->tile_size));
    give(&pass, gl_int("tile_columns", room->tile_columns));
    give(&pass, gl_int("mask_width", room->mask_width));
    give(&pass, gl_int("marks", marks));
    give(&pass, gl_float("light_share", light->share));
    if (room->line_rows > 0) {
        struct wedge_cells cells;
        wedge_cells_init(light, part_count(work->solver), &cells);
        fill_lines(&cells, &lines);
        give_lines(&pass, &lines, room->line_rows, cells.bins);
    }
    pass.draw.blend = light == work->lights ? GL_BLEND_OFF : GL_BLEND_ADD;
    cover(room, &pass, room->programs.wedge, work->target);
}

/* The light's pieces one after another, added up. */
static void draw_all(const struct work *work, bool marks)
{
    struct wedge_room *room = work->room;
    for (size_t i = 0; i < work->light_count; i++) {
        const struct wedge_light *light = &work->lights[i];
        double start = clock_ms();
        wedge_tables_place(room, light);
        room->setup_ms += clock_ms() - start;
        draw_setup(room, light);
        draw_tiles(room, light, work->frame);
        draw_lists(room, light);
        draw_masks(room);
        draw_wedges(work, light, marks);
    }
}

/* How many pixels were cut short. */
static pnb_status count_cut(struct wedge_room *room, struct gl_texture *visibility,
                            size_t *out_count)
{
    pnb_context *context = room->parts->context;
    size_t pixels = (size_t)gl_texture_width(visibility) * (size_t)gl_texture_height(visibility);
    float *texels = memory_alloc(context, pixels, sizeof(*texels));
    if (!texels)
        return status_no_memory(context, pixels * sizeof(*texels));
    pnb_status status = gl_texture_read(visibility, 0, texels);
    *out_count = 0;
    for (size_t i = 0; i < pixels && status == PNB_OK; i++)
        *out_count += texels[i] < 0;
    memory_free(context, texels);
    return status;
}

/* A software rasteriser that ends loops is asked whether it did. Then more is done in one turn of a
 * loop, or silhouettes are taken from the light's middle, from now on; where even these are too
 * many, what was summed so far stands. */
static pnb_status draw_frame(const struct work *work, double *lost_ms)
{
    pnb_solver *solver = work->solver;
    struct wedge_room *room = work->room;
    bool asks = gl_device_get_info(room->device)->software;
    pnb_status status = PNB_OK;
    size_t cut = 0;
    for (;;) {
        double begun = clock_ms();
        draw_all(work, asks);
        if (asks)
            status = count_cut(room, work->visibility, &cut);
        if (status != PNB_OK || cut == 0 || room->search == WEDGE_SEARCH_CENTER)
            break;
        status = make_sums(solver, room, room->search + 1, room->line_rows);
        *lost_ms += clock_ms() - begun;
        if (status != PNB_OK)
            break;
        if (room->search == WEDGE_SEARCH_CENTER)
            solver_warn(solver, "more turns of a loop than this software rasteriser allows: "
                                "silhouettes=center is taken");
    }
    if (status == PNB_OK && cut > 0) {
        solver_warn(solver, "some pixels take more turns of a loop than this software rasteriser "
                            "allows: what is hidden there is not counted to the end (cut_pixels)");
        draw_all(work, false);
    }
    solver_count(solver, "cut_pixels", (double)cut);
    return status;
}

/* Programs for the light's cells, if they are not those for the last one's. */
static pnb_status prepare_cells(const struct work *work)
{
    struct wedge_room *room = work->room;
    int rows = 0;
    for (size_t i = 0; i < work->light_count; i++)
        if (has_lines(work->solver, &work->lights[i])) {
            struct wedge_cells cells;
            wedge_cells_init(&work->lights[i], part_count(work->solver), &cells);
            rows = cells.row_count > rows ? cells.row_count : rows;
        }
    rows = (rows + 3) / 4 * 4; /* few kinds of programs */
    return rows == room->line_rows ? PNB_OK : make_sums(work->solver, room, room->search, rows);
}

static pnb_status draw_light(struct work *work, double *lost_ms)
{
    struct wedge_room *room = work->room;
    bool changed;
    double start = clock_ms();
    pnb_status status = wedge_parts_cut(room->parts, &work->lights[0], &changed);
    if (status == PNB_OK && (changed || !room->uploaded))
        status = wedge_tables_upload(room);
    if (status == PNB_OK)
        status = wedge_tables_resize(room, work->frame->width, work->frame->height);
    room->setup_ms = clock_ms() - start;
    if (status == PNB_OK)
        status = prepare_cells(work);
    struct gl_target_desc desc = {.colors = {{work->visibility, 0}}};
    if (status == PNB_OK)
        status = gl_target_create(room->device, &desc, &work->target);
    if (status == PNB_OK)
        status = draw_frame(work, lost_ms);
    gl_target_destroy(work->target);
    return status;
}

static pnb_status wedge_draw(pnb_solver *solver, struct opengl_state *state,
                             const struct light_shape *shape, const pnb_light *light,
                             const struct gl_frame *frame, struct gl_texture *visibility)
{
    struct wedge_room *room = state->room;
    struct work work = {solver, room, frame, .visibility = visibility};
    pnb_status status = wedge_lights_create(solver->context, shape, state->occluders, &work.lights,
                                            &work.light_count);
    if (status != PNB_OK)
        return status;
    status = draw_light(&work, &state->lost_ms);
    solver_count(solver, "pieces", (double)work.light_count);
    memory_free(solver->context, work.lights);
    size_t lists, items;
    wedge_tables_bytes(room, &lists, &items);
    solver_count(solver, "setup_ms", room->setup_ms);
    solver_count(solver, "silhouettes", (double)room->parts->part_count);
    solver_count(solver, "tile", room->tile_size);
    solver_count(solver, "lists_mb", (double)lists / (1 << 20));
    solver_count(solver, "items_mb", (double)items / (1 << 20));
    return status;
}

static const struct opengl_method opengl = {wedge_create, wedge_destroy, wedge_changed, wedge_draw,
                                            .edges = true};

#define TILE                                                                                       \
    {                                                                                              \
        "tile", PNB_PARAM_INTEGER, "0", 0, 1024, NULL, "pixels that share a list; 0: automatic"    \
    }
#define SILHOUETTES "edges that are silhouettes from the light's center, or from each point"

static const pnb_param_info params[] = {
    {"silhouettes", PNB_PARAM_CHOICE, "center", 0, 0, "center|point", SILHOUETTES},
    TILE,
};

static const pnb_param_info blend_params[] = {
    {"silhouettes", PNB_PARAM_CHOICE, "point", 0, 0, "center|point", SILHOUETTES},
    {"parts", PNB_PARAM_CHOICE, "4", 0, 0, "1|4|8|16",
     "parts of the light: 4 its quarters, 8 radial, 16 a grid"},
    {"overlap", PNB_PARAM_CHOICE, "gravity", 0, 0, "rectangle|gravity",
     "where a part is hidden: bounding rectangle, or box around the centre of gravity"},
    TILE,
};

#define RECORD(identifier, word, heading, source, sentence, list)                                  \
    const struct method identifier = {                                                             \
        .info =                                                                                    \
            {                                                                                      \
                .name = word,                                                                      \
                .title = heading,                                                                  \
                .paper = source,                                                                   \
                .summary = sentence,                                                               \
                .lights = PNB_LIGHT_BIT(PNB_LIGHT_RECTANGLE) | PNB_LIGHT_BIT(PNB_LIGHT_DISK) |     \
                          PNB_LIGHT_BIT(PNB_LIGHT_POLYGON),                                        \
                .receivers = PNB_RECEIVERS_ANY,                                                    \
                .processor = PNB_PROCESSOR_OPENGL,                                                 \
                .params = list,                                                                    \
                .param_count = sizeof(list) / sizeof(*list),                                       \
            },                                                                                     \
        .create = opengl_create,                                                                   \
        .destroy = opengl_destroy,                                                                 \
        .update = opengl_update,                                                                   \
        .visibility = opengl_visibility,                                                           \
        .opengl = &opengl,                                                                         \
    }

RECORD(method_wedge, "wedge", "penumbra wedges, added",
       "Akenine-Moeller, Assarsson: Approximate Soft Shadows on Arbitrary Surfaces using Penumbra "
       "Wedges (2002)",
       "Each silhouette edge hides the part of the light that it sweeps; all parts are added.",
       params);
RECORD(method_wedge_probabilistic, "wedge-probabilistic", "penumbra wedges, multiplied",
       "Assarsson, Dougherty, Mounier, Akenine-Moeller: An Optimized Soft Shadow Volume Algorithm "
       "with Real-Time Performance (2003)",
       "Like wedge; the visibilities of the silhouettes are multiplied.", params);
RECORD(method_wedge_blend, "wedge-blend", "penumbra wedges, blended",
       "Forest, Barthe, Paulin: Realistic Soft Shadows by Penumbra-Wedges Blending (2006)",
       "Like wedge; per silhouette and part of the light the hidden area and where it lies, so "
       "that overlaps are counted once.",
       blend_params);
