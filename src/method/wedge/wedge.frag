// Visibility of the light at each fragment from the wedges that reach its tile.
//
// BLEND 0, MIDDLE 1: `wedge`, sums; BLEND 0, MIDDLE 0: `wedge-probabilistic`, products; BLEND 1:
// `wedge-blend`. Silhouette after silhouette (part after part), the silhouette's buffer and the
// final one are variables of this fragment.
//
// Loops over set bits look for the next one in a loop of their own: software rasterisers run every
// branch of an `if`, but leave a loop when all their lanes have.
#include "gl/receiver.glsl"
#include "method/wedge/common.glsl"
#if LINE_ROWS > 0
#include "method/wedge/sum_lines.glsl"
#else
#include "method/wedge/sum.glsl"
#endif

// Cells of which less is hidden count as seen.
#define NOTHING 1e-5

uniform vec3 light_center, light_x_axis, light_y_axis, light_half_u, light_half_v, light_normal;
uniform float light_gap;
uniform sampler2D part_low, part_high, group_low, group_high;
uniform sampler2D item_a, item_b, item_c, item_d; // light space, of setup.frag
uniform highp usampler2D list, prefix, item_mask, group_info;
uniform int tile_size, tile_columns, coarse, coarse_columns;
uniform int word_count, list_width, list_rows, mask_width;

// Whether a pixel whose loops the device ended is to show it, by being less than it is by this.
uniform int marks;
uniform float light_share; // of the whole light, of which this is a piece
#define CUT 4.0

layout(location = 0) out float out_visibility;

vec2 project(vec3 a, vec3 p)
{
    return a.xy + (a.xy - p.xy) * (a.z / (p.z - a.z));
}

vec3 cross_at(vec3 a, vec3 b, float z)
{
    float t = (z - a.z) / (b.z - a.z);
    return vec3(a.xy + (b.xy - a.xy) * t, z);
}

// A silhouette edge adds its wedge.
void add_edge(inout Sum s, ivec2 at, float side, vec3 p, float level)
{
    vec4 a4 = texelFetch(item_a, at, 0);
    vec3 a = a4.xyz, b = texelFetch(item_b, at, 0).xyz;
    bool cut_a = a.z >= level, cut_b = b.z >= level;
    float w = cut_a && cut_b ? 0.0 : 2.0 * side * a4.w;
    vec3 cut = cross_at(a, b, level);
    a = cut_a ? cut : a;
    b = cut_b && !cut_a ? cut : b;
    sum_add(s, w, project(a, p), project(b, p));
}

// The lowest of the silhouettes found; none: adds nothing.
void take_edge(inout Sum s, int group, uint plus, inout uint found, vec3 p, float level)
{
    int i = max(lowest_bit(found), 0);
    float side = found == 0u ? 0.0 : (plus >> uint(i) & 1u) != 0u ? 1.0 : -1.0;
    found &= found - 1u;
    add_edge(s, fold(group * 32 + i), side, p, level);
}

// A face that lies across the fragment's level closes the outline there.
void add_face(inout Sum s, ivec2 at, vec3 p, float level)
{
    vec4 a4 = texelFetch(item_a, at, 0), b4 = texelFetch(item_b, at, 0);
    vec3 a = a4.xyz, b = b4.xyz, c = texelFetch(item_c, at, 0).xyz;
    vec4 plane = texelFetch(item_d, at, 0);
    float facing = dot(plane.xyz, p) + plane.w >= 0.0 ? 1.0 : -1.0;
    float w = a4.w * (a4.w < 1.0 ? facing - 1.0 : facing);
    bool ka = a.z < level, kb = b.z < level, kc = c.z < level;
    w = (ka == kb && kb == kc) || level <= light_gap ? 0.0 : w;
    // Of the face's three sides two cross the level; vertices in the order of their numbers.
    vec3 ab = cross_at(a, b, level), bc = cross_at(b, c, level), ac = cross_at(a, c, level);
    vec3 from = ka && !kb ? ab : kb && !kc ? bc : ac;
    vec3 to = !ka && kb ? ab : !kb && kc ? bc : ac;
    bool same = b4.w > 0.0;
    w = w == 0.0 ? 0.0 : w;
    vec3 e = w == 0.0 ? vec3(0.0) : same ? from : to, f = w == 0.0 ? vec3(0.0) : same ? to : from;
    sum_add(s, w, project(e, p), project(f, p));
}

// A tile's list: group after group.
struct List {
    int count, tile, big; // places; numbers of the tile and its coarse tile
    int slot;             // the place
    int group;            // taken last
    uint word;            // items of it that are left
    bool masked;          // word has only items that matter to the tile
};

// Goes on to the next place unless a group with an item is found. Groups without a mask are asked
// for their boxes.
void find_step(inout List l, vec3 p)
{
    bool go = l.word == 0u && l.slot < l.count;
    int row = l.slot / list_width;
    ivec2 at = ivec2(l.slot - row * list_width, l.big * list_rows + row);
    uint word = texelFetch(item_mask, ivec2(min(l.slot, mask_width - 1), l.tile), 0).x;
    int group = go ? int(texelFetch(list, at, 0).x) : l.group;
    bool masked = l.slot < mask_width;
#if TRIES > 1
    if (!masked) {
#else
    for (int once = masked ? 1 : 0; once < 1; once++) {
#endif
        vec3 low = texelFetch(group_low, fold(group), 0).xyz;
        vec3 high = texelFetch(group_high, fold(group), 0).xyz;
        word = misses(low, high, p, p, true) ? 0u : 0xffffffffu;
    }
    l.word = go ? word : l.word;
    l.masked = go ? masked : l.masked;
    l.group = group;
    l.slot += go ? 1 : 0;
}

// Goes on to a group that has an item. Several places a turn: software rasterisers count turns.
void find_group(inout List l, vec3 p)
{
    while (l.word == 0u && l.slot < l.count) {
        find_step(l, p);
#if TRIES > 1
        find_step(l, p);
        find_step(l, p);
        find_step(l, p);
#endif
    }
}

// Takes the lowest item of word into found if it is a silhouette, into plus if its first face is
// seen (with CENTER the sign stands in the weight).
void try_item(int group, vec3 p, inout uint word, inout uint found, inout uint plus)
{
    uint bit = word & (~word + 1u);
    ivec2 at = fold(group * 32 + max(lowest_bit(word), 0));
#if CENTER
    bool front = true, back = texelFetch(item_a, at, 0).w == 0.0;
#else
    vec4 first = texelFetch(item_c, at, 0), second = texelFetch(item_d, at, 0);
    bool front = dot(first.xyz, p) + first.w >= 0.0;
    bool back = dot(second.xyz, p) + second.w >= 0.0;
#endif
    found |= front != back ? bit : 0u;
    plus |= front ? bit : 0u;
    word &= ~bit;
}

// The silhouettes of this fragment among a group's edges; in plus those whose first face it sees.
// What remains in word was not tried.
uint silhouettes(List l, inout uint word, vec3 p, out uint plus)
{
    uint found = 0u;
    plus = 0u;
#if CENTER
    plus = found = l.masked ? word : 0u;
    word &= ~found;
#endif
    while (word != 0u) {
        try_item(l.group, p, word, found, plus);
#if TRIES > 1 // a turn: software rasterisers count turns (README)
        try_item(l.group, p, word, found, plus);
        try_item(l.group, p, word, found, plus);
        try_item(l.group, p, word, found, plus);
#endif
    }
    return found;
}

#if BLEND
struct Hidden { // of the cells of one row
    CELLS area, x0, x1, y0, y1;
};

#if LINE_ROWS > 0
#define FILL(j) TAKE(cell_area[j])
#else
#define FILL(j) CELLS(1.0)
#endif

#if GRAVITY
// A box around the centre of gravity, as large as the cell lets it be on the nearer side, and no
// smaller than the area: right for a half-plane and for a corner.
Hidden hidden_row(Sum s, int j)
{
    Hidden h;
    CELLS over = 1.0 / max(s.area[j], 1e-6);
    CELLS gx = s.moment_x[j] * over, gy = s.moment_y[j] * over;
#if LINE_ROWS > 0
    // Within the cell's bounds, and in units of these.
    CELLS width = TAKE(cell_width[j]), height = TAKE(cell_height[j]);
    h.area = clamp(s.area[j] / max(width * height, 1e-9), CELLS(0.0), FILL(j));
    gx = (gx - TAKE(cell_x[j])) / max(width, 1e-6);
    gy = (gy - TAKE(cell_y[j])) / max(height, 1e-6);
#else
    h.area = clamp(s.area[j], 0.0, 1.0);
#endif
    gx = clamp(gx, 0.0, 1.0);
    gy = clamp(gy, 0.0, 1.0);
    CELLS hx = min(gx, 1.0 - gx), hy = min(gy, 1.0 - gy);
    CELLS grow = sqrt(max(h.area / max(4.0 * hx * hy, 1e-12), 1.0));
    hx *= grow;
    hy *= grow;
    h.x0 = max(gx - hx, 0.0);
    h.x1 = min(gx + hx, 1.0);
    h.y0 = max(gy - hy, 0.0);
    h.y1 = min(gy + hy, 1.0);
    return h;
}
#else
// The bounds of the edges inside, out to the borders that are covered. A covered cell without an
// edge is covered wholly.
Hidden hidden_row(Sum s, int j)
{
    Hidden h;
    h.area = clamp(s.area[j], 0.0, 1.0);
    h.x0 = s.x0[j] * step(s.left[j], CELLS(NOTHING));
    h.x1 = mix(s.x1[j], CELLS(1.0), 1.0 - step(s.right[j], CELLS(NOTHING)));
    h.y0 = s.y0[j] * step(s.level[j], CELLS(NOTHING));
    h.y1 = mix(s.y1[j], CELLS(1.0), 1.0 - step(s.level[j + 1], CELLS(NOTHING)));
    CELLS empty_x = step(h.x1, h.x0), empty_y = step(h.y1, h.y0);
    h.x0 *= 1.0 - empty_x;
    h.x1 = mix(h.x1, CELLS(1.0), empty_x);
    h.y0 *= 1.0 - empty_y;
    h.y1 = mix(h.y1, CELLS(1.0), empty_y);
    return h;
}
#endif

// Section 3.2: what silhouette s hides joins what is hidden already; epsilon of it is counted by
// both. Where either hides nothing the other stays as it is.
void blend(inout Hidden f, Hidden s, CELLS fill)
{
    CELLS box_f = (f.x1 - f.x0) * (f.y1 - f.y0), box_s = (s.x1 - s.x0) * (s.y1 - s.y0);
    CELLS beta = max(min(f.x1, s.x1) - max(f.x0, s.x0), 0.0) *
                 max(min(f.y1, s.y1) - max(f.y0, s.y0), 0.0);
    CELLS epsilon = min(f.area / max(box_f, NOTHING), 1.0) *
                    min(s.area / max(box_s, NOTHING), 1.0) * beta;
    CELLS new_s = 1.0 - step(s.area, CELLS(NOTHING)), old_f = 1.0 - step(f.area, CELLS(NOTHING));
    CELLS both = new_s * old_f;
    CELLS x0 = min(f.x0, s.x0), x1 = max(f.x1, s.x1), y0 = min(f.y0, s.y0), y1 = max(f.y1, s.y1);
    CELLS area = f.area + s.area - min(epsilon, min(f.area, s.area));
    area = min(area, min((x1 - x0) * (y1 - y0), fill));
    CELLS only_s = new_s * (1.0 - old_f);
    f.area = mix(mix(f.area, s.area, only_s), area, both);
    f.x0 = mix(mix(f.x0, s.x0, only_s), x0, both);
    f.x1 = mix(mix(f.x1, s.x1, only_s), x1, both);
    f.y0 = mix(mix(f.y0, s.y0, only_s), y0, both);
    f.y1 = mix(mix(f.y1, s.y1, only_s), y1, both);
}
#endif

float total(CELLS v)
{
#if COLUMNS == 1
    return v;
#else
    return dot(v, CELLS(1.0));
#endif
}

#if LINE_ROWS > 0
// The share of the light where  slope . (x, y) + height <= 0: below the receiver's horizon. The
// horizon is one edge, all across.
float below_horizon(vec2 slope, float height)
{
    float steep = max(abs(slope.x), 1e-6 * abs(slope.y));
    if (steep == 0.0)
        return height > 0.0 ? 0.0 : 1.0;
    steep = slope.x < 0.0 ? -steep : steep;
    Sum s;
    sum_clear(s);
    sum_add(s, 1.0, vec2((slope.y - height) / steep, -1.0), vec2((-slope.y - height) / steep, 1.0));
    float left = 0.0;
    for (int j = 0; j < ROWS; j++)
        left += total(s.area[j]);
    left /= light_area;
    return steep > 0.0 ? left : 1.0 - left;
}
#else
// The share of the light where  slope . (x, y) + height <= 0: below the receiver's horizon.
float below_horizon(vec2 slope, float height)
{
    vec2 c = abs(slope.x) >= abs(slope.y) ? slope : slope.yx;
    if (c.x == 0.0)
        return height > 0.0 ? 0.0 : 1.0;
    // Along each line of the light up to a place, linear from line to line; both ends in [0,1].
    float ua = 0.5 - 0.5 * (height - c.y) / c.x, ub = 0.5 - 0.5 * (height + c.y) / c.x;
    float ca = clamp(ua, 0.0, 1.0), cb = clamp(ub, 0.0, 1.0), du = ub - ua;
    float up_to = abs(du) < 1e-6 ? ca
                                 : ((cb - ca) * 0.5 * (ca + cb) + max(ub, 1.0) - max(ua, 1.0)) / du;
    return c.x > 0.0 ? up_to : 1.0 - up_to;
}
#endif

void main()
{
    Receiver r = receiver_here();
    vec3 d = r.lifted - light_center;
    vec3 p = vec3(dot(light_x_axis, d), dot(light_y_axis, d), dot(light_normal, d));
    p = r.valid && p.z > 0.0 ? p : vec3(0.0, 0.0, 1.0);
    float level = p.z * (1.0 - NEAR);
    ivec2 tile = ivec2(gl_FragCoord.xy) / tile_size, big = tile / coarse;
    List l;
    l.tile = tile.y * tile_columns + tile.x;
    l.big = big.y * coarse_columns + big.x;
    l.count = r.valid ? int(texelFetch(prefix, ivec2(word_count, l.big), 0).x) : 0;
    l.slot = 0;
    l.group = 0;
    l.word = 0u;
    l.masked = true;

#if BLEND
    Hidden final[ROWS];
    for (int j = 0; j < ROWS; j++)
        final[j] = Hidden(CELLS(0.0), CELLS(0.0), CELLS(0.0), CELLS(0.0), CELLS(0.0));
#elif MIDDLE
    float hard = 0.0, soft = 0.0;
#else
    float seen = 1.0;
#endif
    Sum s;
    sum_clear(s);
    int part = 0;
    uint left = 0u; // items that were given up
    find_group(l, p);
    // One turn for each part of each group, and one more for the last part.
    for (bool last = false; !last;) {
        last = l.word == 0u;
        uvec4 info = texelFetch(group_info, fold(l.group), 0);
        uint upto = (2u << uint(max(lowest_bit(l.word), 0))) - 1u, next = info.y & ~upto;
        uint these = l.word & (next == 0u ? 0xffffffffu : (next & (~next + 1u)) - 1u);
        uint mine = these;
        int here = last ? -1 : int(info.x) + bit_count(info.y & upto);
        // Parts that share a group are small: many are seen beside the light. And of a part with
        // masks (which leave it out) and groups without, nothing or all must count.
        if (info.w == GROUP_MIXED || l.count > mask_width) {
            ivec2 box = fold(max(here, 0));
            vec3 low = texelFetch(part_low, box, 0).xyz, high = texelFetch(part_high, box, 0).xyz;
            mine = misses(low, high, p, p, false) ? 0u : mine;
            here = last || mine != 0u ? here : part;
        }
        for (; part != here; part = here) { // not an `if`: see above
#if BLEND
            for (int j = 0; j < ROWS; j++)
                blend(final[j], hidden_row(s, j), FILL(j));
#else
#if LINE_ROWS > 0
            float all = clamp(s.area[0] / light_area, 0.0, 1.0);
#else
            float all = clamp(s.area[0], 0.0, 1.0);
#endif
#if MIDDLE
            float middle = s.middle > 0.5 ? 1.0 : 0.0;
            hard = max(hard, middle);
            soft += all - middle;
#else
            seen *= 1.0 - all;
#endif
#endif
            sum_clear(s);
        }
        uint edges = mine & ~info.z, faces = mine & info.z;
        uint plus, found = silhouettes(l, edges, p, plus);
        while (found != 0u) {
            take_edge(s, l.group, plus, found, p, level);
#if TRIES > 1
            take_edge(s, l.group, plus, found, p, level);
            take_edge(s, l.group, plus, found, p, level);
            take_edge(s, l.group, plus, found, p, level);
#endif
        }
        while (faces != 0u) {
            int i = lowest_bit(faces);
            faces &= faces - 1u;
            add_face(s, fold(l.group * 32 + i), p, level);
        }
        left |= edges | found | faces;
        l.word &= ~these;
        find_group(l, p);
    }
    bool cut = left != 0u || l.word != 0u || l.slot < l.count || part != -1;
#if BLEND
    float hidden = 0.0;
    for (int j = 0; j < ROWS; j++)
#if LINE_ROWS > 0
        hidden += total(final[j].area * TAKE(cell_width[j]) * TAKE(cell_height[j])) / light_area;
#else
        hidden += total(final[j].area) / float(COLUMNS * ROWS);
#endif
    float v = 1.0 - hidden;
#elif MIDDLE
    float v = 1.0 - (hard + soft);
#else
    float v = seen;
#endif
    // What lies below the horizon is hidden by the receiver's own surface, which mostly is a part too.
    vec2 slope = vec2(dot(r.normal, light_half_u), dot(r.normal, light_half_v));
    v = min(v, 1.0 - below_horizon(slope, -dot(r.normal, d)));
    v = light_share * (r.valid ? clamp(v, 0.0, 1.0) : 1.0);
    out_visibility = cut && marks > 0 ? v - CUT : v;
}
