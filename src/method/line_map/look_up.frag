// The share of the light that a receiver sees, segment by segment, after the paper's shade(); as
// light.c, which says why. LIFT, BESIDE and PIECES_WIDE are opengl.c's.
#include "gl/receiver.glsl"
#include "method/line_map/frame.glsl"

uniform sampler2DArray depths;
uniform sampler2DArray channels; // of segment i: 2 i the left sample's, 2 i + 1 the right one's
uniform sampler2D places;        // a texel per sample: s, low, scale
uniform sampler2D row_frame;
uniform sampler2D sectors; // a texel per sector: low, 1 / step, first row, rows (0: nothing casts)
uniform sampler2D floors;  // corners of the floors that the maps do not cover, 3 texels a triangle
uniform sampler2D pieces;     // (a, r) to (a, r), PIECES_WIDE a row
uniform sampler2D piece_rows; // of map y and row x: the first of its pieces
uniform bool spans;
uniform int sample_count;
uniform bool no_maps; // nothing casts
uniform bool round_rows;
uniform vec3 start; // of the line, world
uniform vec3 axis;
uniform vec3 axis_y;
uniform vec3 axis_z;
uniform float line_length;
uniform float near_r;
uniform float phi_step;
uniform float bias;
uniform float weight;
uniform vec4 floor_planes[16];
uniform vec2 floor_triangles[16]; // first, count
uniform int floor_count;

out float visibility;

const float TURN = 6.28318530717958648;

// The receiver in the frame.
vec3 point; // (a, y, z), lifted
float q_point;
int row;
vec2 row_normal; // its tangent plane's normal within the row
float plane_d;
float height_low, height_high;
bool below_floor;

void locate(vec3 position, vec3 normal, float lift)
{
    vec3 d = position - start;
    vec3 p = vec3(dot(axis, d), dot(axis_y, d), dot(axis_z, d));
    vec3 n = vec3(dot(axis, normal), dot(axis_y, normal), dot(axis_z, normal));
    float plane = dot(n, p);
    height_low = -plane;
    height_high = n.x * line_length - plane;
    point = p + lift * n;
    row = -1;
    below_floor = false;
    for (int k = 0; k < floor_count; k++)
        below_floor = below_floor || dot(floor_planes[k].xyz, point) < floor_planes[k].w;
    if (no_maps)
        return;
    float phi = atan(point.z, point.y);
    phi += phi < 0.0 ? TURN : 0.0;
    int count = textureSize(sectors, 0).x;
    int sector = min(int(phi * (float(count) / TURN)), count - 1);
    vec4 arc = texelFetch(sectors, ivec2(sector, 0), 0);
    if (arc.w <= 0.0)
        return;
    float off = phi - arc.x;
    off += off < -0.5 * TURN ? TURN : 0.0;
    float r = floor(off * arc.y);
    if (round_rows)
        r = clamp(r, 0.0, arc.w - 1.0);
    if (r < 0.0 || r >= arc.w)
        return;
    row = int(arc.z + r);
    q_point = 1.0 / max(length(point.yz), near_r);
    vec2 turned = texelFetch(row_frame, ivec2(row, 0), 0).xy;
    row_normal = vec2(n.x, dot(n.yz, turned));
    plane_d = plane + lift;
}

int column_of(vec3 place)
{
    float x = (spread((point.x - place.x) * q_point) - place.y) * place.z;
    return x >= 0.0 && x < map_size.x ? int(x) : -1;
}

bool beneath_floor(float s)
{
    vec3 light = vec3(s, 0.0, 0.0);
    for (int k = 0; k < floor_count; k++) {
        float below = dot(floor_planes[k].xyz, point) - floor_planes[k].w;
        if (!(below < 0.0))
            continue;
        float above = dot(floor_planes[k].xyz, light) - floor_planes[k].w;
        vec3 x = point + (light - point) * (below / (below - above));
        for (int t = 0; t < int(floor_triangles[k].y); t++) {
            vec3 c[3], side;
            for (int i = 0; i < 3; i++)
                c[i] = texelFetch(floors, ivec2(3 * (int(floor_triangles[k].x) + t) + i, 0), 0).xyz;
            for (int i = 0; i < 3; i++)
                side[i] = dot(floor_planes[k].xyz, cross(c[(i + 1) % 3] - c[i], x - c[i]));
            if (all(greaterThanEqual(side, vec3(0.0))) || all(lessThanEqual(side, vec3(0.0))))
                return true;
        }
    }
    return false;
}

bool sample_seen(int layer, vec3 place)
{
    if (below_floor && beneath_floor(place.x))
        return false;
    if (row < 0)
        return true;
    int column = column_of(place);
    if (column < 0)
        return true;
    float q = texelFetch(depths, ivec3(column, row, layer), 0).x;
    if (q <= 0.0)
        return true;
    // The receiver's own tangent plane tells its depth at the texel's middle.
    float own = q_point, under = plane_d - row_normal.x * place.x;
    float plane = (row_normal.x * column_u(place, column) + row_normal.y) / under;
    if (plane > 0.0)
        own = clamp(plane, 0.5 * own, 2.0 * own);
    return q <= own * (1.0 + bias * max(phi_step, 1.0 / place.z));
}

float channel_at(int layer, vec3 place)
{
    int column = row < 0 ? -1 : column_of(place);
    if (column < 0)
        return -1.0;
    float share = texelFetch(channels, ivec3(column, row, layer), 0).x;
    return share > 1.5 ? -1.0 : share;
}

float one_sided(float skin, float height, float other_height)
{
    if (other_height > 0.0)
        return skin >= 0.0 ? skin : 0.5;
    float horizon = height / (height - other_height);
    return skin >= 0.0 ? min(skin, horizon) : horizon;
}

// The hidden parts of the light, disjoint, as spans.c finds them.
const int INTERVALS = 16;
int cover_count;
vec2 covered[INTERVALS];

void cover(float begin, float end)
{
    for (int k = 0; k < cover_count;) {
        if (covered[k].x > end || covered[k].y < begin) {
            k++;
            continue;
        }
        begin = min(begin, covered[k].x);
        end = max(end, covered[k].y);
        cover_count--;
        covered[k] = covered[cover_count];
        k = 0;
    }
    if (cover_count < INTERVALS)
        covered[cover_count++] = vec2(begin, end);
}

void find_cover()
{
    float r_p = 1.0 / q_point;
    cover_count = 0;
    for (int m = 0; m < sample_count; m++) {
        float texel = max(phi_step, 1.0 / texelFetch(places, ivec2(m, 0), 0).z);
        float least = LIFT * texel * r_p, most = r_p * (1.0 - BESIDE * texel);
        int first = int(texelFetch(piece_rows, ivec2(row, m), 0).x);
        int last = int(texelFetch(piece_rows, ivec2(row + 1, m), 0).x);
        for (int i = first; i < last; i++) {
            vec4 piece = texelFetch(pieces, ivec2(i % PIECES_WIDE, i / PIECES_WIDE), 0);
            vec2 p0 = piece.xy, p1 = piece.zw;
            float h0 = dot(row_normal, p0) - plane_d - least;
            float h1 = dot(row_normal, p1) - plane_d - least;
            if ((p0.y > most && p1.y > most) || (h0 <= 0.0 && h1 <= 0.0))
                continue;
            if (h0 < 0.0 || h1 < 0.0) {
                vec2 at = p0 + h0 / (h0 - h1) * (p1 - p0);
                if (h0 < 0.0)
                    p0 = at;
                else
                    p1 = at;
                if (p0.y > most && p1.y > most)
                    continue;
            }
            if (p0.y > most)
                p0 = vec2(p0.x + (most - p0.y) / (p1.y - p0.y) * (p1.x - p0.x), most);
            else if (p1.y > most)
                p1 = vec2(p1.x + (most - p1.y) / (p0.y - p1.y) * (p0.x - p1.x), most);
            float s0 = point.x + (p0.x - point.x) * r_p / (r_p - p0.y);
            float s1 = point.x + (p1.x - point.x) * r_p / (r_p - p1.y);
            float begin = max(min(s0, s1), 0.0), end = min(max(s0, s1), line_length);
            if (begin < end)
                cover(begin, end);
        }
    }
}

float uncovered(float low, float high)
{
    float seen = high - low;
    for (int k = 0; k < cover_count; k++)
        seen -= max(min(covered[k].y, high) - max(covered[k].x, low), 0.0);
    return max(seen, 0.0);
}

float look_up()
{
    if (sample_count < 2) {
        if (height_low <= 0.0 && height_high <= 0.0)
            return 0.0;
        if (below_floor && beneath_floor(0.5 * line_length))
            return 0.0;
        return height_low > 0.0 && height_high > 0.0
                   ? 1.0
                   : max(height_low, height_high) / abs(height_high - height_low);
    }
    if (row < 0 && height_low > 0.0 && height_high > 0.0 && !below_floor)
        return 1.0;
    float sum = 0.0, height = height_low;
    vec3 left = texelFetch(places, ivec2(0, 0), 0).xyz;
    bool seen = height > 0.0 && sample_seen(0, left), asked = false;
    for (int i = 0; i + 1 < sample_count; i++) {
        vec3 right = texelFetch(places, ivec2(i + 1, 0), 0).xyz;
        float next_height = height_low + (height_high - height_low) * right.x / line_length;
        bool next_seen = next_height > 0.0 && sample_seen(i + 1, right);
        float share = 0.0;
        if (seen && next_seen) {
            float a = channel_at(2 * i, left), b = channel_at(2 * i + 1, right);
            share = a >= 0.0 && b >= 0.0 ? min(a + b, 1.0) : 1.0;
        } else if (seen) {
            share = one_sided(channel_at(2 * i, left), height, next_height);
        } else if (next_seen) {
            share = one_sided(channel_at(2 * i + 1, right), next_height, height);
        }
        bool dark = next_height <= 0.0 && height <= 0.0;
        if (spans && share < 1.0 && !dark && row >= 0 && !below_floor) {
            if (!asked)
                find_cover();
            asked = true;
            float from = left.x, to = right.x;
            float across = from + (to - from) * height / (height - next_height);
            if (height <= 0.0)
                from = across;
            else if (next_height <= 0.0)
                to = across;
            float between = uncovered(from, to) / (right.x - left.x);
            share = seen && next_seen ? between : max(share, between);
        }
        sum += share * (right.x - left.x);
        left = right;
        seen = next_seen;
        height = next_height;
    }
    return clamp(sum / line_length, 0.0, 1.0);
}

void main()
{
    visibility = 0.0;
    Receiver receiver = receiver_here();
    if (!receiver.valid)
        return;
    locate(receiver.position, receiver.normal, receiver.lift);
    visibility = weight * look_up();
}
