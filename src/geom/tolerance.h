/* geom/tolerance.h: every tolerance of the project, with its unit and what breaks when it changes.
 */
#ifndef GEOM_TOLERANCE_H
#define GEOM_TOLERANCE_H

/* Receivers are lifted off their surface along the geometric normal by this share of the scene's
 * extent (the largest absolute coordinate of its bounds) before visibility is asked for. Every
 * method that traces or projects from the receiver uses it, through scene_receiver_lift(). Smaller:
 * surfaces shadow themselves where float rounding puts the point below them. Larger: contact
 * shadows start late. */
#define TOLERANCE_RECEIVER_LIFT (1.0 / 131072.0)

/* Occluders nearer to a light sample than this share of the distance from receiver to sample do not
 * count: METHODS' open segment, with room for rounding, so that a lamp flush with a ceiling shines.
 */
#define TOLERANCE_LIGHT_GAP (1.0 / 65536.0)

/* A polygonal light's corners may leave their common plane by this share of its size. */
#define TOLERANCE_LIGHT_PLANARITY 1e-4

/* Two lights or directions count as degenerate below this share of the scale at hand. */
#define TOLERANCE_DEGENERATE 1e-12

#endif
