// The frame of a set of maps, as in map/map.h: rows are half-planes through the light's line,
// columns are spread directions u = (a - s) / r. A place is (s, low, scale) of a map.

uniform bool wide;
uniform vec2 map_size; // columns, rows

float spread(float u)
{
    if (!wide || abs(u) <= 1.0)
        return u;
    return u > 0.0 ? 2.0 - 1.0 / u : -2.0 - 1.0 / u;
}

float unspread(float w)
{
    if (!wide || abs(w) <= 1.0)
        return w;
    return w > 0.0 ? 1.0 / max(2.0 - w, 1e-6) : -1.0 / max(2.0 + w, 1e-6);
}

// Direction of column c's middle.
float column_u(vec3 place, int c)
{
    return unspread(place.y + (float(c) + 0.5) / place.z);
}
