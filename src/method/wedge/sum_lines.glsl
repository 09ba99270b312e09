// What one part hides of a light that is no rectangle, or of cells that are none: sums over its
// outline as in sum.glsl, over the rows of cells.c. In a row each column lies between two straight
// lines l and r, and an edge adds
//     integral over y of clamp(x(y), l(y), r(y)) - l(y)
// as the integral of max(x - l, 0) less that of max(x - r, 0). All in light space; an edge is cut at
// the light's box first, so that far ends cost no digits.

uniform vec4 row_span[LINE_ROWS]; // low, high, 1 / (high - low); behind the last: far above
uniform vec4 left_low[LINE_ROWS], left_high[LINE_ROWS], right_low[LINE_ROWS],
    right_high[LINE_ROWS];        // of the columns, at the row's ends
uniform vec4 bin_end;             // rows below the end of each bin
uniform vec4 cell_x[ROWS], cell_y[ROWS], cell_width[ROWS], cell_height[ROWS]; // bounds
uniform vec4 cell_area[ROWS]; // share of its bounds that the cell fills
uniform float light_area;

#if COLUMNS == 1
#define CELLS float
#define TAKE(v) (v).x
#elif COLUMNS == 2
#define CELLS vec2
#define TAKE(v) (v).xy
#else
#define CELLS vec4
#define TAKE(v) (v)
#endif

struct Sum {
    CELLS area[ROWS];
#if BLEND
    CELLS moment_x[ROWS], moment_y[ROWS];
#endif
#if MIDDLE
    float middle; // layers over the light's middle
#endif
};

void sum_clear(out Sum s)
{
    for (int j = 0; j < ROWS; j++) {
        s.area[j] = CELLS(0.0);
#if BLEND
        s.moment_x[j] = CELLS(0.0);
        s.moment_y[j] = CELLS(0.0);
#endif
    }
#if MIDDLE
    s.middle = 0.0;
#endif
}

// Mean over an edge's piece of max(x - l, 0), x and l from a to b; and of its moments.
struct Beyond {
    CELLS area, x, y;
};

Beyond beyond(vec2 a, vec2 b, CELLS la, CELLS lb)
{
    CELLS fa = a.x - la, fb = b.x - lb, pa = max(fa, 0.0), pb = max(fb, 0.0), d = fb - fa;
    CELLS flat_ = 1.0 - step(1e-6, abs(d)), ahead = step(fa, CELLS(0.0));
    CELLS share = mix((pb - pa) * ((1.0 - flat_) / (d + flat_)), 1.0 - ahead, flat_);
    Beyond r;
    r.area = 0.5 * share * (pa + pb);
#if BLEND
    // The product of two things that are linear along the share of the edge from t0 to t1.
    CELLS t0 = (1.0 - share) * ahead, t1 = t0 + share;
    CELLS ga = a.x + la, gb = b.x + lb, g0 = mix(ga, gb, t0), g1 = mix(ga, gb, t1);
    CELLS y0 = a.y + (b.y - a.y) * t0, y1 = a.y + (b.y - a.y) * t1;
    CELLS from = 2.0 * pa + pb, to = pa + 2.0 * pb;
    r.x = share * (from * g0 + to * g1) / 12.0;
    r.y = share * (from * y0 + to * y1) / 6.0;
#endif
    return r;
}

// A piece with |x| <= 1.
void sum_piece(inout Sum s, float w, vec2 a, vec2 b)
{
    float dy = b.y - a.y, slope = abs(dy) > 1e-20 ? (b.x - a.x) / dy : 0.0;
    vec2 o = abs(a.y) < abs(b.y) ? a : b;
    float low = min(a.y, b.y), high = max(a.y, b.y);
    int first = 0;
    for (int r = 0; r < LINE_ROWS; r++)
        first += row_span[r].y <= low ? 1 : 0;
    for (int j = 0; j < ROWS; j++) {
        int end = int(bin_end[j]);
        for (int r = max(first, j > 0 ? int(bin_end[max(j - 1, 0)]) : 0);
             r < end && row_span[r].x < high; r++) {
            vec4 span = row_span[r];
            vec2 ya_yb = clamp(vec2(a.y, b.y), span.x, span.y);
            vec2 x = clamp(o.x + (ya_yb - o.y) * slope, -1.0, 1.0);
            vec2 t = (ya_yb - span.x) * span.z;
            vec2 u = vec2(x.x, ya_yb.x), v = vec2(x.y, ya_yb.y);
            CELLS ll = TAKE(left_low[r]), lh = TAKE(left_high[r]);
            CELLS rl = TAKE(right_low[r]), rh = TAKE(right_high[r]);
            Beyond left = beyond(u, v, mix(ll, lh, t.x), mix(ll, lh, t.y));
            Beyond right = beyond(u, v, mix(rl, rh, t.x), mix(rl, rh, t.y));
            float wy = w * (v.y - u.y);
            s.area[j] += wy * (left.area - right.area);
#if BLEND
            s.moment_x[j] += wy * (left.x - right.x);
            s.moment_y[j] += wy * (left.y - right.y);
#endif
        }
    }
}

// An edge of the outline on the light, from a to b, with w layers more on its left: what of it lies
// within |x| <= 1, and what lies right of that, moved to x = 1.
void sum_add(inout Sum s, float w, vec2 a, vec2 b)
{
    vec2 d = b - a, o = abs(a.x) + abs(a.y) < abs(b.x) + abs(b.y) ? a : b;
#if MIDDLE
    float up = float(b.y > 0.0) - float(a.y > 0.0);
    float slope = abs(d.y) > 1e-20 ? d.x / d.y : 0.0;
    s.middle += o.x - o.y * slope > 0.0 ? w * up : 0.0;
#endif
    float rise = abs(d.x) > 1e-20 ? d.y / d.x : 0.0, least = min(a.y, b.y), most = max(a.y, b.y);
    float xa = clamp(a.x, -1.0, 1.0), xb = clamp(b.x, -1.0, 1.0);
    float ya = xa == a.x ? a.y : clamp(o.y + (xa - o.x) * rise, least, most);
    float yb = xb == b.x ? b.y : clamp(o.y + (xb - o.x) * rise, least, most);
    float from = a.x > 1.0 ? a.y : yb, to = b.x > 1.0 ? b.y : a.x > 1.0 ? ya : yb;
    bool gone = w == 0.0 || (xa == xb && abs(xa) == 1.0);
    for (int k = gone || ya == yb ? 1 : 0; k < (w == 0.0 || from == to ? 1 : 2); k++) {
        bool inside = k == 0;
        sum_piece(s, w, inside ? vec2(xa, ya) : vec2(1.0, from),
                  inside ? vec2(xb, yb) : vec2(1.0, to));
    }
}
