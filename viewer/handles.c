/* viewer/handles.c: taking hold of lights and objects on the canvas.
 *
 * A drag is counted from the last point: the pointer's ray against a plane through the handle (the
 * picture's, or the level one while Shift is held) or against an axis. A ray that misses, or hits
 * far outside the scene, changes nothing; so a light can be dragged anywhere, through the floor and
 * into an occluder, but not to infinity.
 */
#include "handles.h"

#define REACH_PX  14.0 /* how near the pointer must be */
#define ARM_PX    64.0 /* length of the axes and of the arrow */
#define BORDER_PX 20.0 /* marks of what is out of sight keep this far from the edge */
#define FAR_RADII 40.0

static const vec3 axis_of[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

static struct view_frame_axes pick_axes(const struct view_app *app, struct view_pick pick)
{
    return view_light_axes(&app->state.lights[pick.index], view_app_middle(app),
                           view_app_sun_distance(app));
}

static int add(struct view_handle *out, int count, const struct view_lens *lens,
               enum view_handle_type type, vec3 place, double sign)
{
    struct view_handle handle = {.type = type, .place = place, .sign = sign};
    if (count >= VIEW_HANDLES_MAX || !v3_finite(place) ||
        !view_lens_project(lens, place, &handle.x, &handle.y))
        return count;
    out[count] = handle;
    return count + 1;
}

/* The mark of a thing: at the border of the canvas if the thing is out of sight. */
static int add_mark(struct view_handle *out, int count, const struct view_lens *lens,
                    enum view_handle_type type, vec3 place, size_t index)
{
    struct view_handle handle = {.type = type, .place = place, .index = index};
    double w = lens->width, h = lens->height;
    if (count >= VIEW_HANDLES_MAX || !v3_finite(place))
        return count;
    bool front = view_lens_project(lens, place, &handle.x, &handle.y);
    if (!front || handle.x < 0 || handle.y < 0 || handle.x > w || handle.y > h) {
        vec3 r = v3_sub(place, lens->eye);
        double dx = front ? handle.x - 0.5 * w : v3_dot(r, lens->right);
        double dy = front ? handle.y - 0.5 * h : -v3_dot(r, lens->up);
        double reach = fmax(fabs(dx) / (0.5 * w - BORDER_PX), fabs(dy) / (0.5 * h - BORDER_PX));
        reach = reach > 0 ? reach : 1;
        handle.x = 0.5 * w + dx / reach;
        handle.y = 0.5 * h + dy / reach;
        handle.outside = true;
    }
    out[count] = handle;
    return count + 1;
}

static vec3 spin_place(const struct view_app *app, size_t object, vec3 middle, double arm)
{
    const double *m = app->state.placements[object];
    /* It follows the object's own x axis, so that turning is seen. */
    vec3 x = v3_unit(v3(m[0], 0, m[8]), v3(1, 0, 0));
    vec3 turned = v3_turn(x, v3(0, 1, 0), M_PI / 4);
    return v3_mad(middle, turned, arm);
}

int view_handles_find(const struct view_app *app, const struct view_lens *lens,
                      struct view_handle *out)
{
    int count = 0;
    vec3 place;
    for (size_t i = 0; i < app->state.light_count && i < 32; i++) {
        struct view_pick other = {VIEW_PICK_LIGHT, i};
        if (app->pick.type == VIEW_PICK_LIGHT && app->pick.index == i)
            continue;
        if (view_app_pick_place(app, other, &place))
            count = add_mark(out, count, lens, VIEW_HANDLE_OTHER, place, i);
    }
    if (!view_app_pick_place(app, app->pick, &place))
        return count;
    double arm = ARM_PX * view_lens_pixel_size(lens, place);
    count = add_mark(out, count, lens, VIEW_HANDLE_MOVE, place, 0);
    if (count > 0 && out[count - 1].outside)
        return count;
    for (int k = 0; k < 3; k++)
        count = add(out, count, lens, VIEW_HANDLE_X + k, v3_mad(place, axis_of[k], arm), 0);
    /* A plane's own turn about the vertical is nothing that a scene file can say. */
    if (app->pick.type == VIEW_PICK_OBJECT && app->scene->objects[app->pick.index].plane)
        return count;
    if (app->pick.type == VIEW_PICK_OBJECT)
        return add(out, count, lens, VIEW_HANDLE_SPIN,
                   spin_place(app, app->pick.index, place, 0.8 * arm), 0);
    pnb_light_type type = app->state.lights[app->pick.index].light.type;
    struct view_frame_axes axes = pick_axes(app, app->pick);
    if (type == PNB_LIGHT_POINT)
        return count;
    for (double sign = -1; sign <= 1; sign += 2) {
        count =
            add(out, count, lens, VIEW_HANDLE_U, v3_mad(place, axes.u, sign * axes.half_u), sign);
        if (type != PNB_LIGHT_LINE)
            count = add(out, count, lens, VIEW_HANDLE_V, v3_mad(place, axes.v, sign * axes.half_v),
                        sign);
    }
    if (type == PNB_LIGHT_LINE) /* a line is aimed by its end */
        return add(out, count, lens, VIEW_HANDLE_AIM,
                   v3_mad(place, axes.u, axes.half_u + 0.5 * arm), 0);
    return add(out, count, lens, VIEW_HANDLE_AIM, v3_mad(place, axes.n, 1.2 * arm), 0);
}

struct view_handle view_handles_at(const struct view_app *app, const struct view_lens *lens,
                                   double x, double y)
{
    struct view_handle all[VIEW_HANDLES_MAX], best = {VIEW_HANDLE_NONE};
    int count = view_handles_find(app, lens, all);
    double nearest = REACH_PX;
    for (int i = 0; i < count; i++) {
        double distance = hypot(all[i].x - x, all[i].y - y);
        /* Of those at one place, moving wins. */
        if (all[i].type == VIEW_HANDLE_MOVE)
            distance -= 3;
        if (distance < nearest) {
            nearest = distance;
            best = all[i];
        }
    }
    return best;
}

const char *view_handle_hint(enum view_handle_type type, enum view_pick_type pick)
{
    switch (type) {
    case VIEW_HANDLE_NONE: return NULL;
    case VIEW_HANDLE_MOVE:
        return pick == VIEW_PICK_LIGHT ? "Drag to move the light; Shift: level"
                                       : "Drag to move the object; Shift: level";
    case VIEW_HANDLE_X: return "Drag to move along x";
    case VIEW_HANDLE_Y: return "Drag to move up and down";
    case VIEW_HANDLE_Z: return "Drag to move along z";
    case VIEW_HANDLE_U:
    case VIEW_HANDLE_V: return "Drag to change the light's size";
    case VIEW_HANDLE_AIM: return "Drag to aim the light";
    case VIEW_HANDLE_SPIN: return "Drag to turn the object";
    case VIEW_HANDLE_OTHER: return "Press to select this light";
    }
    return NULL;
}

/* ---- dragging ---- */

static bool pointer_point(const struct view_grab *grab, const struct view_app *app,
                          const struct view_lens *lens, double x, double y, vec3 *out)
{
    enum view_handle_type type = grab->handle.type;
    double farthest =
        FAR_RADII * app->scene->radius + 2 * v3_length(v3_sub(lens->eye, view_app_middle(app)));
    switch (type) {
    case VIEW_HANDLE_X:
    case VIEW_HANDLE_Y:
    case VIEW_HANDLE_Z:
        return view_lens_on_axis(lens, x, y, grab->anchor, axis_of[type - VIEW_HANDLE_X], farthest,
                                 out);
    case VIEW_HANDLE_U:
        return view_lens_on_axis(lens, x, y, grab->axes.center, grab->axes.u, farthest, out);
    case VIEW_HANDLE_V:
        return view_lens_on_axis(lens, x, y, grab->axes.center, grab->axes.v, farthest, out);
    default:
        /* What is beside or behind the eye moves as fast as what is in the middle of the scene. */
        if (grab->handle.outside && !grab->level)
            return view_lens_on_plane(lens, x, y, view_app_middle(app), lens->forward, farthest,
                                      out);
        return view_lens_on_plane(lens, x, y, grab->anchor,
                                  grab->level ? v3(0, 1, 0) : lens->forward, farthest, out);
    }
}

static void anchor(struct view_grab *grab, const struct view_app *app, const struct view_lens *lens,
                   double x, double y)
{
    view_app_pick_place(app, grab->pick, &grab->anchor);
    grab->anchored = pointer_point(grab, app, lens, x, y, &grab->start);
    grab->x = x;
    grab->y = y;
}

void view_grab_begin(struct view_grab *grab, const struct view_app *app,
                     const struct view_lens *lens, const struct view_handle *handle, double x,
                     double y)
{
    *grab = (struct view_grab){.handle = *handle, .pick = app->pick};
    if (grab->pick.type == VIEW_PICK_LIGHT)
        grab->axes = pick_axes(app, grab->pick);
    anchor(grab, app, lens, x, y);
}

static bool size_light(struct view_grab *grab, struct view_app *app, vec3 point)
{
    struct view_light *light = &app->state.lights[grab->pick.index];
    struct view_frame_axes now = pick_axes(app, grab->pick);
    bool u = grab->handle.type == VIEW_HANDLE_U;
    double along = v3_dot(v3_sub(point, grab->axes.center), u ? grab->axes.u : grab->axes.v) -
                   v3_dot(v3_sub(grab->start, grab->axes.center), u ? grab->axes.u : grab->axes.v);
    double half = (u ? grab->axes.half_u : grab->axes.half_v) + grab->handle.sign * along;
    if (light->light.type == PNB_LIGHT_SUN) {
        double tangent = fmax(half, 0) / view_app_sun_distance(app);
        view_light_resize(light, &now, tangent, tangent, 1e-4);
        return true;
    }
    view_light_resize(light, &now, u ? half : now.half_u, u ? now.half_v : half,
                      view_app_smallest(app));
    return true;
}

/* The handle's point follows the pointer round the light's middle. */
static bool aim_light(struct view_grab *grab, struct view_app *app, const struct view_lens *lens,
                      double x, double y)
{
    struct view_light *light = &app->state.lights[grab->pick.index];
    struct view_frame_axes now = pick_axes(app, grab->pick);
    bool line = light->light.type == PNB_LIGHT_LINE;
    vec3 from = line ? now.u : now.n;
    double cx, cy;
    if (!view_lens_project(lens, now.center, &cx, &cy))
        return false;
    /* Where the ray meets a ball of the arrow's length, or its rim. */
    double radius = 1.2 * ARM_PX, dx = (x - cx) / radius, dy = (cy - y) / radius;
    double r = hypot(dx, dy);
    if (r > 1) {
        dx /= r;
        dy /= r;
        r = 1;
    }
    double depth = sqrt(fmax(0, 1 - r * r));
    if (v3_dot(from, lens->forward) > 0)
        depth = -depth;
    vec3 to = v3_mad(v3_mad(v3_scale(lens->right, dx), lens->up, dy), lens->forward, -depth);
    to = v3_unit(to, from);
    vec3 axis = v3_cross(from, to);
    double sine = v3_length(axis);
    if (sine < 1e-9)
        return false;
    view_light_turn(light, v3_scale(axis, 1 / sine), atan2(sine, v3_dot(from, to)));
    return true;
}

static bool spin_object(struct view_grab *grab, struct view_app *app, vec3 point)
{
    vec3 middle = grab->anchor;
    vec3 a = v3_sub(grab->start, middle), b = v3_sub(point, middle);
    double turn = atan2(b.x, b.z) - atan2(a.x, a.z);
    if (!isfinite(turn) || turn == 0)
        return false;
    double *m = app->state.placements[grab->pick.index];
    for (int column = 0; column < 4; column++) {
        vec3 p = v3(m[column], m[4 + column], m[8 + column]);
        p = column == 3 ? v3_add(middle, v3_turn(v3_sub(p, middle), v3(0, 1, 0), turn))
                        : v3_turn(p, v3(0, 1, 0), turn);
        m[column] = p.x;
        m[4 + column] = p.y;
        m[8 + column] = p.z;
    }
    grab->start = point;
    return true;
}

bool view_grab_drag(struct view_grab *grab, struct view_app *app, const struct view_lens *lens,
                    double x, double y, bool level)
{
    enum view_handle_type type = grab->handle.type;
    vec3 point;
    if (!view_app_pick_place(app, grab->pick, &point))
        return false;
    if (type == VIEW_HANDLE_AIM)
        return aim_light(grab, app, lens, x, y);
    level = level || type == VIEW_HANDLE_SPIN;
    if (level != grab->level) {
        grab->level = level;
        anchor(grab, app, lens, grab->x, grab->y);
    }
    grab->x = x;
    grab->y = y;
    if (!pointer_point(grab, app, lens, x, y, &point))
        return false;
    if (!grab->anchored) {
        anchor(grab, app, lens, x, y);
        return false;
    }
    if (type == VIEW_HANDLE_U || type == VIEW_HANDLE_V)
        return size_light(grab, app, point);
    if (type == VIEW_HANDLE_SPIN)
        return spin_object(grab, app, point);
    vec3 by = v3_sub(point, grab->start);
    grab->start = point;
    view_app_pick_move(app, grab->pick, by);
    return v3_length(by) > 0;
}

/* ---- drawing ---- */

static void set_color(cairo_t *cr, unsigned rgb, double alpha)
{
    cairo_set_source_rgba(cr, (rgb >> 16 & 255) / 255.0, (rgb >> 8 & 255) / 255.0,
                          (rgb & 255) / 255.0, alpha);
}

/* A light line over a dark one can be seen on any picture. */
static void stroke(cairo_t *cr, unsigned rgb, double width)
{
    cairo_set_line_cap(cr, CAIRO_LINE_CAP_ROUND);
    cairo_set_line_join(cr, CAIRO_LINE_JOIN_ROUND);
    set_color(cr, 0x000000, 0.55);
    cairo_set_line_width(cr, width + 2);
    cairo_stroke_preserve(cr);
    set_color(cr, rgb, 1);
    cairo_set_line_width(cr, width);
    cairo_stroke(cr);
}

static void dot(cairo_t *cr, double x, double y, double radius, unsigned rgb)
{
    cairo_new_path(cr);
    cairo_arc(cr, x, y, radius, 0, 2 * M_PI);
    set_color(cr, rgb, 1);
    cairo_fill_preserve(cr);
    set_color(cr, 0x000000, 0.6);
    cairo_set_line_width(cr, 1.2);
    cairo_stroke(cr);
}

static bool trace_outline(const struct view_app *app, const struct view_lens *lens, cairo_t *cr,
                          size_t index)
{
    vec3 points[VIEW_OUTLINE_MAX];
    const struct view_light *light = &app->state.lights[index];
    int count = view_light_outline(light, view_app_middle(app), view_app_sun_distance(app), points);
    cairo_new_path(cr);
    for (int i = 0; i < count; i++) {
        double x, y;
        if (!view_lens_project(lens, points[i], &x, &y) || fabs(x) > 1e5 || fabs(y) > 1e5)
            return false;
        cairo_line_to(cr, x, y);
    }
    if (count > 2)
        cairo_close_path(cr);
    return count > 1;
}

static void draw_outline(const struct view_app *app, const struct view_lens *lens, cairo_t *cr,
                         size_t index, bool selected)
{
    const pnb_light *light = &app->state.lights[index].light;
    unsigned rgb = selected ? 0xffd75e : 0xd8c48a;
    if (!trace_outline(app, lens, cr, index))
        return;
    if (light->type != PNB_LIGHT_LINE) {
        set_color(cr, rgb, selected ? 0.28 : 0.16);
        cairo_fill_preserve(cr);
    }
    stroke(cr, rgb, selected ? 2.5 : 1.5);
}

static void draw_sun_rays(cairo_t *cr, double x, double y, unsigned rgb)
{
    for (int k = 0; k < 8; k++) {
        double a = M_PI / 4 * k;
        cairo_new_path(cr);
        cairo_move_to(cr, x + 11 * cos(a), y + 11 * sin(a));
        cairo_line_to(cr, x + 17 * cos(a), y + 17 * sin(a));
        stroke(cr, rgb, 2);
    }
}

/* Points from the mark at the border to where the thing is. */
static void draw_pointer(const struct view_lens *lens, cairo_t *cr, const struct view_handle *mark,
                         unsigned rgb)
{
    double a = atan2(mark->y - 0.5 * lens->height, mark->x - 0.5 * lens->width);
    cairo_new_path(cr);
    cairo_move_to(cr, mark->x + 18 * cos(a), mark->y + 18 * sin(a));
    cairo_line_to(cr, mark->x + 9 * cos(a + 0.9), mark->y + 9 * sin(a + 0.9));
    cairo_line_to(cr, mark->x + 9 * cos(a - 0.9), mark->y + 9 * sin(a - 0.9));
    cairo_close_path(cr);
    set_color(cr, rgb, 1);
    cairo_fill_preserve(cr);
    set_color(cr, 0x000000, 0.6);
    cairo_set_line_width(cr, 1.2);
    cairo_stroke(cr);
}

static void draw_arm(cairo_t *cr, const struct view_handle *from, const struct view_handle *to,
                     unsigned rgb)
{
    cairo_new_path(cr);
    cairo_move_to(cr, from->x, from->y);
    cairo_line_to(cr, to->x, to->y);
    stroke(cr, rgb, 2);
}

void view_handles_draw(const struct view_app *app, const struct view_lens *lens, cairo_t *cr,
                       const struct view_handle *hot)
{
    static const unsigned axis_rgb[3] = {0xf66151, 0x8ff0a4, 0x62a0ea};
    struct view_handle all[VIEW_HANDLES_MAX], *move = NULL;
    int count = view_handles_find(app, lens, all);
    for (size_t i = 0; i < app->state.light_count; i++)
        draw_outline(app, lens, cr, i, app->pick.type == VIEW_PICK_LIGHT && app->pick.index == i);
    for (int i = 0; i < count; i++) {
        if (all[i].type == VIEW_HANDLE_OTHER) {
            if (app->state.lights[all[i].index].light.type == PNB_LIGHT_SUN)
                draw_sun_rays(cr, all[i].x, all[i].y, 0xd8c48a);
            dot(cr, all[i].x, all[i].y, 5, 0xd8c48a);
            if (all[i].outside)
                draw_pointer(lens, cr, &all[i], 0xd8c48a);
        } else if (all[i].type == VIEW_HANDLE_MOVE) {
            move = &all[i];
        }
    }
    for (int i = 0; move && i < count; i++)
        if (all[i].type >= VIEW_HANDLE_X && all[i].type <= VIEW_HANDLE_Z)
            draw_arm(cr, move, &all[i], axis_rgb[all[i].type - VIEW_HANDLE_X]);
        else if (all[i].type == VIEW_HANDLE_AIM)
            draw_arm(cr, move, &all[i], 0xffd75e);
        else if (all[i].type == VIEW_HANDLE_SPIN)
            draw_arm(cr, move, &all[i], 0xdc8add);
    for (int i = 0; move && i < count; i++) {
        unsigned rgb = 0xffffff;
        double radius = 5;
        if (all[i].type == VIEW_HANDLE_OTHER)
            continue;
        if (all[i].type >= VIEW_HANDLE_X && all[i].type <= VIEW_HANDLE_Z)
            rgb = axis_rgb[all[i].type - VIEW_HANDLE_X];
        else if (all[i].type == VIEW_HANDLE_AIM)
            rgb = 0xffd75e;
        else if (all[i].type == VIEW_HANDLE_SPIN)
            rgb = 0xdc8add;
        else if (all[i].type == VIEW_HANDLE_MOVE)
            radius = 7;
        if (all[i].outside) {
            rgb = app->pick.type == VIEW_PICK_LIGHT ? 0xffd75e : 0xffffff;
            draw_pointer(lens, cr, &all[i], rgb);
        }
        if (hot && hot->type == all[i].type && hot->sign == all[i].sign)
            radius += 2.5;
        if (all[i].type == VIEW_HANDLE_MOVE && app->pick.type == VIEW_PICK_LIGHT &&
            app->state.lights[app->pick.index].light.type == PNB_LIGHT_SUN)
            draw_sun_rays(cr, all[i].x, all[i].y, 0xffd75e);
        dot(cr, all[i].x, all[i].y, radius, rgb);
    }
}

void view_handles_bounds(const struct view_app *app, const struct view_lens *lens,
                         graphene_rect_t *out)
{
    double x0 = INFINITY, y0 = INFINITY, x1 = -INFINITY, y1 = -INFINITY, x, y;
    struct view_handle all[VIEW_HANDLES_MAX];
    vec3 points[VIEW_OUTLINE_MAX];
    int count = view_handles_find(app, lens, all);
    for (int i = 0; i < count; i++) {
        x0 = fmin(x0, all[i].x);
        x1 = fmax(x1, all[i].x);
        y0 = fmin(y0, all[i].y);
        y1 = fmax(y1, all[i].y);
    }
    for (size_t k = 0; k < app->state.light_count; k++) {
        count = view_light_outline(&app->state.lights[k], view_app_middle(app),
                                   view_app_sun_distance(app), points);
        for (int i = 0; i < count; i++) {
            if (!view_lens_project(lens, points[i], &x, &y))
                continue;
            x0 = fmin(x0, x);
            x1 = fmax(x1, x);
            y0 = fmin(y0, y);
            y1 = fmax(y1, y);
        }
    }
    x0 = fmax(x0 - 24, 0);
    y0 = fmax(y0 - 24, 0);
    x1 = fmin(x1 + 24, lens->width);
    y1 = fmin(y1 + 24, lens->height);
    *out =
        GRAPHENE_RECT_INIT((float)x0, (float)y0, (float)fmax(x1 - x0, 0), (float)fmax(y1 - y0, 0));
}
