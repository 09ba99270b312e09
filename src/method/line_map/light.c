/* method/line_map/light.c: one linear light: its samples, its segments, and the look-up.
 *
 * Look-up of a receiver p, segment by segment between neighbouring samples l and r, after the
 * paper's shade(): both see it: the whole segment (the paper's 0.5 + 0.5), unless skins lie before
 * it in both maps, then the sum of both channels; one sees it: that map's channel; none: umbra. A
 * sample below p's tangent plane does not see it, and the segment ends where that plane cuts it.
 * Where one sample sees p and its channel has no skin, the paper's initial value stands: half the
 * segment. Segments count by their lengths; a sample inside the light thus carries both of its
 * segments.
 *
 * Beyond the paper (between=spans), where a segment is not seen whole: what the surfaces that any
 * map sees leave of it (spans.c); of the two, where one sample or none sees p, the greater, for a
 * surface may hide its own receivers by what the maps' resolution rounds.
 *
 * It differs from the paper's sum of channels in one thing: which samples see p decides first, so a
 * texel's width of disagreement between depth test and skin leaves no line.
 */
#include <string.h>

#include "method/line_map/line_map.h"

static pnb_status segment_init(struct line_map_light *light, struct line_map_segment *segment,
                               size_t left, size_t right)
{
    size_t texels = (size_t)light->set->rows * (size_t)light->set->columns;
    *segment = (struct line_map_segment){.left = left, .right = right};
    segment->from_left = memory_alloc(light->context, texels, sizeof(uint16_t));
    segment->from_right = memory_alloc(light->context, texels, sizeof(uint16_t));
    if (!segment->from_left || !segment->from_right)
        return status_no_memory(light->context, 2 * texels * sizeof(uint16_t));
    return PNB_OK;
}

static void segment_finish(struct line_map_light *light, struct line_map_segment *segment)
{
    memory_free(light->context, segment->from_left);
    memory_free(light->context, segment->from_right);
    segment->from_left = segment->from_right = NULL;
}

static pnb_status make_maps(struct line_map_light *light, size_t samples)
{
    struct map_sample *places = memory_alloc(light->context, samples, sizeof(*places));
    if (!places)
        return status_no_memory(light->context, samples * sizeof(*places));
    double step = light->set->length / (double)(samples - 1), started = clock_ms();
    for (size_t i = 0; i < samples; i++) {
        double low = i > 0 ? (double)(i - 1) : 0,
               high = i + 1 < samples ? (double)(i + 1) : (double)i;
        places[i] = (struct map_sample){(double)i * step, low * step, high * step};
    }
    pnb_status status = map_set_add(light->set, places, samples);
    light->method->map_ms += clock_ms() - started;
    memory_free(light->context, places);
    return status;
}

pnb_status line_map_light_create(struct line_map *method, vec3 from, vec3 to, size_t samples,
                                 struct line_map_light **out_light)
{
    pnb_context *context = method->geometry->context;
    *out_light = NULL;
    struct line_map_light *light = memory_calloc(context, 1, sizeof(*light));
    if (!light)
        return status_no_memory(context, sizeof(*light));
    light->method = method;
    light->context = context;
    double started = clock_ms();
    vec3 along = v3_sub(to, from);
    struct map_set_desc desc = {.geometry = method->geometry,
                                .origin = from,
                                .axis = v3_normalize(along),
                                .length = v3_length(along),
                                .rows = method->rows,
                                .columns = method->columns};
    pnb_status status = map_set_create(&desc, &light->set);
    method->map_ms += clock_ms() - started;
    if (status == PNB_OK && !light->set->empty)
        status = make_maps(light, samples);
    if (status == PNB_OK && !light->set->empty) {
        started = clock_ms();
        if (!memory_reserve(context, (void **)&light->segments, &light->segment_capacity, 0,
                            samples, sizeof(*light->segments)))
            status = status_no_memory(context, samples * sizeof(*light->segments));
        for (size_t i = 0; i + 1 < samples && status == PNB_OK; i++)
            status = segment_init(light, &light->segments[light->segment_count++], i, i + 1);
        if (status == PNB_OK)
            status = line_map_scan(light);
        if (status == PNB_OK)
            status = line_map_warp(light, 0, light->segment_count);
        method->skin_ms += clock_ms() - started;
    }
    if (status != PNB_OK) {
        line_map_light_destroy(light);
        return status;
    }
    *out_light = light;
    return PNB_OK;
}

void line_map_light_destroy(struct line_map_light *light)
{
    if (!light)
        return;
    for (size_t i = 0; i < light->segment_count; i++)
        segment_finish(light, &light->segments[i]);
    line_map_forget_views(light);
    memory_free(light->context, light->segments);
    map_set_destroy(light->set);
    memory_free(light->context, light);
}

pnb_status line_map_light_split(struct line_map_light *light)
{
    pnb_context *context = light->context;
    struct map_set *set = light->set;
    size_t open = 0, first = set->count, old = light->segment_count;
    for (size_t i = 0; i < old; i++)
        open += !light->segments[i].settled;
    if (!open)
        return PNB_OK;
    double started = clock_ms();
    struct map_sample *places = memory_alloc(context, open, sizeof(*places));
    if (!places)
        return status_no_memory(context, open * sizeof(*places));
    for (size_t i = 0, k = 0; i < old; i++) {
        const struct line_map_segment *segment = &light->segments[i];
        double low = set->maps[segment->left].at, high = set->maps[segment->right].at;
        if (!segment->settled)
            places[k++] = (struct map_sample){0.5 * (low + high), low, high};
    }
    pnb_status status = map_set_add(set, places, open);
    memory_free(context, places);
    light->method->map_ms += clock_ms() - started;
    started = clock_ms();
    if (status == PNB_OK)
        status = line_map_scan(light);
    if (status == PNB_OK &&
        !memory_reserve(context, (void **)&light->segments, &light->segment_capacity, old, open,
                        sizeof(*light->segments)))
        status = status_no_memory(context, open * sizeof(*light->segments));
    if (status != PNB_OK)
        return status;

    /* From the end, so that the segments move up in place. */
    size_t to = old + open, map = first + open;
    memset(light->segments + old, 0, open * sizeof(*light->segments));
    light->segment_count = to;
    for (size_t i = old; i-- > 0;) {
        struct line_map_segment whole = light->segments[i];
        light->segments[i].from_left = light->segments[i].from_right = NULL;
        if (whole.settled) {
            light->segments[--to] = whole;
            continue;
        }
        map--;
        light->segments[--to] =
            (struct line_map_segment){.left = map, .right = whole.right, .from_left = NULL};
        light->segments[--to] = (struct line_map_segment){.left = whole.left,
                                                          .right = map,
                                                          .from_left = whole.from_left,
                                                          .from_right = whole.from_right};
    }
    for (size_t i = 0; i < light->segment_count && status == PNB_OK; i++) {
        struct line_map_segment *segment = &light->segments[i];
        if (!segment->from_left)
            status = segment_init(light, segment, segment->left, segment->right);
    }
    /* Runs of segments that are not settled. */
    for (size_t i = 0; i < light->segment_count && status == PNB_OK;) {
        size_t end = i;
        while (end < light->segment_count && !light->segments[end].settled)
            end++;
        if (end > i)
            status = line_map_warp(light, i, end);
        i = end > i ? end : i + 1;
    }
    light->method->skin_ms += clock_ms() - started;
    return status;
}

/* The channel's value at the texel that the receiver falls on; negative: no skin. */
static inline double channel_at(const struct map_set *set, const struct map *map,
                                const uint16_t *channel, const struct map_point *p)
{
    if (p->row < 0)
        return -1;
    int column = map_column(set, map, (p->a - (float)map->at) * p->q);
    if (column < 0)
        return -1;
    uint16_t value = channel[(size_t)p->row * (size_t)set->columns + (size_t)column];
    return value == LINE_MAP_NO_SKIN ? -1 : value * (1.0 / LINE_MAP_SHARE_ONE);
}

/* Share of a segment of which one sample is seen: mine, the other's height above the tangent plane
 * given. */
static double one_sided(double skin, double height, double other_height)
{
    if (other_height > 0)
        return skin >= 0 ? skin : 0.5;
    double horizon = height / (height - other_height);
    return skin >= 0 ? fmin(skin, horizon) : horizon;
}

/* Both see it: all of the segment, or, where skins of both lie before p, an occluder hides the part
 * in between, and the two ends add up. */
static double two_sided(double from_left, double from_right)
{
    return from_left >= 0 && from_right >= 0 ? fmin(from_left + from_right, 1) : 1;
}

static inline bool sample_seen(const struct map_set *set, const struct map *map,
                               const struct map_point *p, float bias)
{
    return map_seen(set, map, p, bias * map_texel(set, map)) &&
           !(p->below_floor && map_beneath_floor(set, p, map->at));
}

/* Where the light between low and high, of these heights above the receiver's plane, is above it.
 */
static void above_horizon(double height, double next_height, double *low, double *high)
{
    double across = *low + (*high - *low) * height / (height - next_height);
    if (height <= 0 && next_height <= 0)
        *low = *high;
    else if (height <= 0)
        *low = across;
    else if (next_height <= 0)
        *high = across;
}

double line_map_look_up(const struct line_map_light *light, const float position[3],
                        const float normal[3], float *shares)
{
    const struct map_set *set = light->set;
    struct map_point p;
    map_locate(set, position, normal, &p);
    double low = p.height_low, high = p.height_high;
    if (light->segment_count == 0) {
        if (low <= 0 && high <= 0)
            return 0;
        double whole = low > 0 && high > 0 ? 1 : fmax(low, high) / fabs(high - low);
        return p.below_floor && map_beneath_floor(set, &p, 0.5 * set->length) ? 0 : whole;
    }
    if (p.row < 0 && low > 0 && high > 0 && !p.below_floor && !shares)
        return 1;
    const float bias = (float)light->method->bias;
    const double per_length = 1 / set->length;
    double sum = 0, height = low;
    const struct map *left = &set->maps[light->segments[0].left];
    bool seen = height > 0 && sample_seen(set, left, &p, bias), asked = false;
    struct line_map_cover cover;
    for (size_t i = 0; i < light->segment_count; i++) {
        const struct line_map_segment *segment = &light->segments[i];
        const struct map *right = &set->maps[segment->right];
        double next_height = low + (high - low) * right->at * per_length, share = 0;
        bool next_seen = next_height > 0 && sample_seen(set, right, &p, bias);
        if (seen && next_seen)
            share = two_sided(channel_at(set, left, segment->from_left, &p),
                              channel_at(set, right, segment->from_right, &p));
        else if (seen)
            share = one_sided(channel_at(set, left, segment->from_left, &p), height, next_height);
        else if (next_seen)
            share = one_sided(channel_at(set, right, segment->from_right, &p), next_height, height);
        bool dark = next_height <= 0 && height <= 0;
        if (light->method->spans && share < 1 && !dark && p.row >= 0 && !p.below_floor) {
            if (!asked)
                line_map_cover(light, &p, &cover);
            asked = true;
            double from = left->at, to = right->at;
            above_horizon(height, next_height, &from, &to);
            double between = line_map_uncovered(&cover, from, to) / (right->at - left->at);
            share = seen && next_seen ? between : fmax(share, between);
        }
        sum += share * (right->at - left->at);
        if (shares)
            shares[i] = (float)share;
        left = right;
        seen = next_seen;
        height = next_height;
    }
    return fmin(fmax(sum * per_length, 0), 1);
}

double line_map_look_up_plain(const struct line_map_light *light, const float position[3],
                              const float normal[3])
{
    const struct map_set *set = light->set;
    struct map_point p;
    map_locate(set, position, normal, &p);
    size_t seen = 0;
    if (p.row < 0 && p.height_low > 0 && p.height_high > 0 && !p.below_floor)
        return 1;
    for (size_t i = 0; i < set->count; i++) {
        double t = set->maps[i].at / set->length;
        double height = p.height_low + (p.height_high - (double)p.height_low) * t;
        seen += height > 0 && sample_seen(set, &set->maps[i], &p, (float)light->method->bias);
    }
    return set->count ? (double)seen / (double)set->count : 1;
}
