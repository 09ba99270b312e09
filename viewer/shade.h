/* viewer/shade.h: from visibility to bytes: the viewer's own shading, quick enough for each frame.
 */
#ifndef VIEWER_SHADE_H
#define VIEWER_SHADE_H

#include <penumbra/penumbra.h>
#include <stdbool.h>

#include "team.h"

/* A light made ready; single precision. */
struct view_emitter {
    pnb_light_type type;
    float color[3];
    float center[3], normal[3]; /* of disk and sun: towards the lit side; the sun's: to the sun */
    float radius;
    bool one_sided;
    int count;       /* vertices of rectangle, polygon; ends of a line */
    float *vertices; /* count x 3, counter-clockwise seen from the lit side */
    float sum_scale; /* of the sun: its colour is irradiance */
};

void view_emitter_init(struct view_emitter *emitter, const pnb_light *light);
void view_emitter_finish(struct view_emitter *emitter);

/* Irradiance per unit of colour at 16 points; 0 where a position is NaN. Relative error below 2e-3
 * where the light is wholly above the horizon. */
enum { VIEW_LANES = 16 };
struct view_points {
    float p[3][VIEW_LANES], n[3][VIEW_LANES];
};
typedef void view_irradiance_fn(const struct view_emitter *emitter,
                                const struct view_points *points, float *out);
view_irradiance_fn view_irradiance_plain, view_irradiance_avx2, view_irradiance_avx512;
/* The quickest one that this processor can. */
view_irradiance_fn *view_irradiance_best(void);

struct view_material {
    float color[3], emission[3];
    bool receives;
};

struct view_shading {
    const pnb_surface_view *view;
    const struct view_material *materials; /* one per object of the scene */
    const struct view_emitter *emitters;
    size_t emitter_count;
    const float *const *visibility; /* one array per emitter; NULL: 1 everywhere */
    float ambient[3], background[3];
    double exposure;
};

/* bgra: width x height x 4 bytes: blue, green, red in sRGB, 255. */
void view_shade(struct view_team *team, const struct view_shading *shading, uint8_t *bgra);
/* Linear values to the same bytes that pnb_image_write() makes of them. */
void view_encode(struct view_team *team, const float *rgb, size_t count, uint8_t *bgra);
/* Visibility as grey, encoded as a picture is; NaN in a dull blue. */
void view_show_visibility(struct view_team *team, const float *visibility, size_t count,
                          uint8_t *bgra);
/* Signed error by the library's diverging map, its ends at -scale and scale; NaN dark. */
void view_show_error(struct view_team *team, const float *visibility, const float *truth,
                     size_t count, double scale, uint8_t *bgra);

#endif
