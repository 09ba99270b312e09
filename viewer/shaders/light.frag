// One light's irradiance times its visibility, to be added up. The formulas are those of
// pnb_light_irradiance(): Lambert's sum over the edges of a polygon, the closed forms of disk and line.
// Where the horizon cuts the light polygons are clipped, and a disk is a polygon of 24 corners and
// equal area. An edge's angle over its sine comes from a rational approximation (largest error 4e-4 of
// the value). Compiled for one kind of light at a time, since a rasteriser on the processor would run
// through all of them: KIND is its pnb_light_type.
uniform sampler2D depth_map, surface_map, shading_map, visibility_map, material_map;
uniform sampler2D corner_map; // corners of a polygon, ends of a line: count x 1
uniform vec3 view_forward, view_right, view_up; // to the picture's middle and its borders
uniform float view_near;
uniform int view_reversed;
uniform int count;
uniform vec3 middle, normal; // relative to the eye; the sun's normal: towards it
uniform float radius, sun_scale;
uniform vec3 amount; // colour x exposure

in vec2 place;
layout(location = 0) out vec4 light;

const float PI = 3.14159265;
const int RECTANGLE = 0, DISK = 1, POLYGON = 2, LINE = 3, POINT = 4, SUN = 5;
const int ROUND = 24;

float edge_term(vec3 a, vec3 b, vec3 n)
{
    vec3 across = cross(a, b);
    float sine = length(across);
    return sine > 0.0 ? atan(sine, dot(a, b)) / sine * dot(n, across) : 0.0;
}

// The same for unit vectors, quickly.
float unit_term(vec3 a, vec3 b, vec3 n)
{
    float c = dot(a, b), y = abs(c);
    float v = (5.36834 + (3.119699 + 0.0912357 * y) * y) / (3.417594 + (4.1616724 + y) * y);
    float turned = PI * inversesqrt(max(1.0 - c * c, 1e-7)) - v;
    return (c > 0.0 ? v : turned) * dot(n, cross(a, b));
}

vec3 round_u, round_v;

vec3 corner(int i, vec3 p)
{
    if (KIND == DISK || KIND == SUN) {
        float a = 2.0 * PI * float(i) / float(ROUND);
        return p + cos(a) * round_u - sin(a) * round_v;
    }
    return texelFetch(corner_map, ivec2(i < count ? i : 0, 0), 0).xyz - p;
}

// p: the point, or for round lights the middle as seen from it.
float clipped_polygon(int corners, vec3 p, vec3 n)
{
    vec3 first = vec3(0.0), last = vec3(0.0), a = corner(0, p);
    float sum = 0.0, ha = dot(a, n);
    bool any = false;
    for (int i = 0; i < corners; i++) {
        vec3 b = corner(i + 1 < corners ? i + 1 : 0, p);
        float hb = dot(b, n);
        if (ha > 0.0 || hb > 0.0) {
            vec3 start = ha <= 0.0 ? mix(a, b, ha / (ha - hb)) : a;
            vec3 end = hb <= 0.0 ? mix(a, b, ha / (ha - hb)) : b;
            if (!any)
                first = start;
            else if (ha <= 0.0)
                sum += edge_term(last, start, n);
            sum += edge_term(start, end, n);
            last = end;
            any = true;
        }
        a = b;
        ha = hb;
    }
    if (any)
        sum += edge_term(last, first, n);
    return max(0.0, -0.5 * sum);
}

// Disk and sun: away is the light's normal away from the point, c its middle seen from there.
float disk_irradiance(vec3 c, vec3 away, vec3 n)
{
    float r2 = radius * radius, h = dot(c, away), up = dot(n, away);
    if (!(h > 0.0))
        return 0.0;
    float above = dot(n, c), slope = radius * sqrt(max(1.0 - up * up, 0.0));
    if (above <= -slope)
        return 0.0;
    if (above < slope) {
        vec3 u = abs(away.x) < 0.6 ? vec3(0.0, away.z, -away.y) : vec3(-away.z, 0.0, away.x);
        float r = radius * sqrt(2.0 * PI / float(ROUND) / sin(2.0 * PI / float(ROUND)));
        round_u = r * normalize(u);
        round_v = cross(away, round_u);
        return clipped_polygon(ROUND, c, n);
    }
    vec3 across = c - h * away;
    float t2 = dot(across, across), m = h * h + r2 - t2, s = sqrt(m * m + 4.0 * t2 * h * h);
    float lifted = m >= 0.0 ? m + s : 4.0 * t2 * h * h / (s - m);
    return max(0.0, PI * r2 / (s * (h * h + t2 + r2 + s)) *
                        (up * lifted + 2.0 * h * dot(n, across)));
}

float line_irradiance(vec3 p, vec3 n)
{
    vec3 a = corner(0, p), b = corner(1, p);
    float ha = dot(a, n), hb = dot(b, n), size = distance(a, b), cut = ha / (ha - hb);
    if (ha <= 0.0 && hb <= 0.0)
        return 0.0;
    vec3 u = (b - a) / size;
    float t = dot(a, u), t0 = t + (ha < 0.0 ? cut : 0.0) * size,
          t1 = t + (hb < 0.0 ? cut : 1.0) * size;
    vec3 foot = a - t * u;
    float d = dot(foot, foot), q0 = sqrt(d + t0 * t0), q1 = sqrt(d + t1 * t1);
    float e1 = t1 / q1, e0 = t0 / q0, width = t1 - t0;
    float across = t0 * t1 > 0.0 ? width * (t0 + t1) / (q0 * q0 * q1 * q1 * (e0 + e1))
                                 : (e1 - e0) / d;
    float along = width * (t0 + t1) / (q0 * q1 * (q0 + q1));
    float sum = dot(n, foot) * across + dot(n, u) * along;
    return sum > 0.0 && sum < 1e30 ? sum : 0.0;
}

float rectangle_irradiance(vec3 p, vec3 n)
{
    vec3 a = corner(0, p), b = corner(1, p), c = corner(2, p), d = corner(3, p);
    float low = min(min(dot(a, n), dot(b, n)), min(dot(c, n), dot(d, n)));
    if (low <= 0.0)
        return clipped_polygon(4, p, n);
    a = normalize(a);
    b = normalize(b);
    c = normalize(c);
    d = normalize(d);
    return max(0.0, -0.5 * (unit_term(a, b, n) + unit_term(b, c, n) + unit_term(c, d, n) +
                            unit_term(d, a, n)));
}

float irradiance(vec3 p, vec3 n)
{
    if (KIND == SUN)
        return disk_irradiance(normal, normal, n) * sun_scale;
    if (KIND == LINE)
        return line_irradiance(p, n);
    if (KIND == POINT) {
        vec3 to = middle - p;
        float d2 = dot(to, to);
        return d2 > 0.0 ? max(0.0, dot(to, n) / (d2 * sqrt(d2))) : 0.0;
    }
    if (KIND == DISK)
        return disk_irradiance(middle - p, -normal, n);
    if (!(dot(p - middle, normal) > 0.0))
        return 0.0;
    return KIND == RECTANGLE ? rectangle_irradiance(p, n) : clipped_polygon(count, p, n);
}

void main()
{
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float object = texelFetch(surface_map, pixel, 0).w;
    if (object < 0.5)
        discard;
    float depth = texelFetch(depth_map, pixel, 0).r;
    float away = view_near / (view_reversed != 0 ? depth : 1.0 - depth);
    vec3 p = away * (view_forward + (2.0 * place.x - 1.0) * view_right +
                     (2.0 * place.y - 1.0) * view_up);
    float v = texelFetch(visibility_map, pixel, 0).r;
    float receives = texelFetch(material_map, ivec2(0, int(object + 0.5) - 1), 0).w;
    if (receives < 0.5 || v < 0.0)
        v = 1.0;
    light = vec4(amount * v * irradiance(p, normalize(texelFetch(shading_map, pixel, 0).xyz)), 0.0);
}
