// What one part hides of the light: sums over its outline as seen from the fragment.
//
// The light is cut into COLUMNS x ROWS cells. For a closed outline around w layers
//     integral of w over a cell = sum over edges of w x integral of clamp(x(y), cell) dy,
// so each edge adds its part by itself, wherever the outline lies, and what is cut off at the
// light's border needs no corner. All sums are continuous in the receiver: no edge is inside or
// outside by a comparison that another edge could see otherwise.

#if COLUMNS == 1
#define CELLS float
#define COLUMN 0.0
#elif COLUMNS == 2
#define CELLS vec2
#define COLUMN vec2(0.0, 1.0)
#else
#define CELLS vec4
#define COLUMN vec4(0.0, 1.0, 2.0, 3.0)
#endif

#define WIDTH (2.0 / float(COLUMNS))
#define HEIGHT (2.0 / float(ROWS))

struct Sum {
    CELLS area[ROWS]; // covered share of each cell
#if BLEND && GRAVITY
    CELLS moment_x[ROWS], moment_y[ROWS]; // of the covered area, in the cell's own [0,1]^2
#elif BLEND
    CELLS left[ROWS], right[ROWS];        // covered lengths of the cells' borders
    CELLS level[ROWS + 1];
    CELLS x0[ROWS], x1[ROWS], y0[ROWS], y1[ROWS]; // bounds of the edges inside
#endif
#if MIDDLE
    float middle; // layers over the light's middle
#endif
};

void sum_clear(out Sum s)
{
    for (int j = 0; j < ROWS; j++) {
        s.area[j] = CELLS(0.0);
#if BLEND && GRAVITY
        s.moment_x[j] = CELLS(0.0);
        s.moment_y[j] = CELLS(0.0);
#elif BLEND
        s.left[j] = s.right[j] = CELLS(0.0);
        s.x0[j] = s.y0[j] = CELLS(1.0);
        s.x1[j] = s.y1[j] = CELLS(0.0);
#endif
    }
#if BLEND && !GRAVITY
    for (int j = 0; j <= ROWS; j++)
        s.level[j] = CELLS(0.0);
#endif
#if MIDDLE
    s.middle = 0.0;
#endif
}

// An edge of the outline on the light, from a to b, with w layers more on its left.
void sum_add(inout Sum s, float w, vec2 a, vec2 b)
{
    float dy = b.y - a.y;
    float slope = abs(dy) > 1e-20 ? (b.x - a.x) / dy : 0.0;
    // x(y) from the end that is nearer to the light: the other may be far out.
    bool from_a = abs(a.x) + abs(a.y) < abs(b.x) + abs(b.y);
    vec2 o = from_a ? a : b;
#if MIDDLE
    float up = float(b.y > 0.0) - float(a.y > 0.0);
    s.middle += o.x - o.y * slope > 0.0 ? w * up : 0.0;
#endif
#if BLEND && !GRAVITY
    for (int j = 0; j <= ROWS; j++) {
        float y = -1.0 + HEIGHT * float(j);
        float up = float(b.y > y) - float(a.y > y);
        s.level[j] += w * up * clamp((o.x + (y - o.y) * slope + 1.0) / WIDTH - COLUMN, 0.0, 1.0);
    }
#endif
    for (int j = 0; j < ROWS; j++) {
        float low = -1.0 + HEIGHT * float(j);
        float ya = clamp(a.y, low, low + HEIGHT), yb = clamp(b.y, low, low + HEIGHT);
        float va = (ya - low) / HEIGHT, vb = (yb - low) / HEIGHT;
        float wv = w * (vb - va);
        CELLS ua = (o.x + (ya - o.y) * slope + 1.0) / WIDTH - COLUMN;
        CELLS ub = (o.x + (yb - o.y) * slope + 1.0) / WIDTH - COLUMN;
        CELLS ca = clamp(ua, 0.0, 1.0), cb = clamp(ub, 0.0, 1.0);
        // Shares of the edge inside the column, and right of it. Differences of the very numbers that
        // are clamped: far out, where they are coarse, the shares still are 0 or 1.
        CELLS du = ub - ua;
        CELLS flat_ = 1.0 - step(1e-6, abs(du));
        CELLS over = (1.0 - flat_) / (du + flat_);
        CELLS right = mix((max(ub, 1.0) - max(ua, 1.0)) * over, step(1.0, ua), flat_);
        CELLS inside = mix((cb - ca) * over, step(0.0, ua) - step(1.0, ua), flat_);
        CELLS mean = 0.5 * (ca + cb);
        s.area[j] += wv * (inside * mean + right);
#if BLEND
        // Ends of the piece inside.
        CELLS along = (vb - va) * over;
        CELLS pa = va + (ca - ua) * along;
        CELLS pb = vb + (cb - ub) * along;
#endif
#if BLEND && GRAVITY
        s.moment_x[j] += wv * (inside * (ca * ca + ca * cb + cb * cb) / 6.0 + 0.5 * right);
        CELLS up = step(0.0, du);
        CELLS end = mix(CELLS(va), CELLS(vb), up), back = (vb - va) * (2.0 * up - 1.0);
        s.moment_y[j] += wv * (inside * (0.5 * (pa + pb) * mean + (pb - pa) * (cb - ca) / 12.0) +
                               right * (end - 0.5 * right * back));
#elif BLEND
        s.left[j] += wv * (inside + right);
        s.right[j] += wv * right;
        CELLS out_ = 4.0 * step(inside * abs(w), CELLS(0.0)); // 4: no bound moves
        out_ += va == vb ? 4.0 : 0.0;
        s.x0[j] = min(s.x0[j], min(ca, cb) + out_);
        s.x1[j] = max(s.x1[j], max(ca, cb) - out_);
        s.y0[j] = min(s.y0[j], min(pa, pb) + out_);
        s.y1[j] = max(s.y1[j], max(pa, pb) - out_);
#endif
    }
}
