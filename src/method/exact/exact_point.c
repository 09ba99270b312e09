/* method/exact/exact_point.c: lights without extent. A point hides behind any one triangle: there
 * is no outline to wind and nothing to share between receivers, so each of them goes down the trees
 * of clusters along its own segment to the light, in double precision, until something is met.
 *
 * Cost: O(nodes near the segment) per receiver, and 64 triangles per cluster that it enters.
 * Triangles that share an edge compute the side of it from the same numbers, the one with the
 * opposite sign, so that no segment slips through between them. A triangle in a plane with the
 * receiver hides nothing, as in exact_cover.c.
 */
#include "geom/tolerance.h"
#include "method/exact/exact.h"

/* From p along e, up to reach of it. */
struct segment {
    vec3 p, e;
    vec3 middle, half; /* of its part up to e, half is without sign */
    double slack;      /* more than rounding moves any of it */
};

static struct segment segment_make(vec3 p, vec3 e, double precision)
{
    struct segment s = {.p = p, .e = e, .middle = v3_mad(p, e, 0.5)};
    s.half = v3(0.5 * fabs(e.x), 0.5 * fabs(e.y), 0.5 * fabs(e.z));
    s.slack = precision * (v3_max_abs(p) + v3_max_abs(e));
    return s;
}

/* Separating axes: those of the box, and their products with the segment. */
static bool meets_box(const struct segment *s, vec3 low, vec3 high)
{
    vec3 m = v3_sub(v3_scale(v3_add(low, high), 0.5), s->middle);
    vec3 h = v3_scale(v3_sub(high, low), 0.5), g = s->half;
    double slack = s->slack + 1e-12 * (fabs(m.x) + fabs(m.y) + fabs(m.z) + h.x + h.y + h.z);
    h = v3_add(h, v3(slack, slack, slack));
    if (fabs(m.x) > h.x + g.x || fabs(m.y) > h.y + g.y || fabs(m.z) > h.z + g.z)
        return false;
    return !(fabs(m.y * s->e.z - m.z * s->e.y) > 2 * (h.y * g.z + h.z * g.y) ||
             fabs(m.z * s->e.x - m.x * s->e.z) > 2 * (h.z * g.x + h.x * g.z) ||
             fabs(m.x * s->e.y - m.y * s->e.x) > 2 * (h.x * g.y + h.y * g.x));
}

static bool meets_triangle(const struct segment *s, const vec3 corners[3])
{
    vec3 q0 = v3_sub(corners[0], s->p), q1 = v3_sub(corners[1], s->p);
    double a = v3_dot(s->e, v3_cross(q0, q1));
    vec3 q2 = v3_sub(corners[2], s->p);
    double b = v3_dot(s->e, v3_cross(q1, q2));
    if ((a < 0 && b > 0) || (a > 0 && b < 0))
        return false;
    double c = v3_dot(s->e, v3_cross(q2, q0));
    vec3 n = v3_cross(v3_sub(q1, q0), v3_sub(q2, q0));
    double along = v3_dot(s->e, n), height = v3_dot(q0, n), side = along < 0 ? -1 : 1;
    if (side * a < 0 || side * b < 0 || side * c < 0 || along == 0 || height == 0)
        return false;
    double t = height / along;
    return t > 0 && t < 1 - TOLERANCE_LIGHT_GAP;
}

/* In world space, where the light and the receiver are: a light on a vertex is on it there. */
static bool meets_cluster(const struct segment *world, const struct exact_instance *instance,
                          size_t cluster)
{
    const struct clusters *mesh = instance->clusters;
    size_t first = cluster * CLUSTER_SIZE, end = first + CLUSTER_SIZE;
    end = end < mesh->slot_count ? end : mesh->slot_count;
    for (size_t slot = first; slot < end; slot++) {
        const uint32_t *v = mesh->corners[slot];
        vec3 corners[3];
        for (int i = 0; i < 3; i++)
            corners[i] = instance->places ? instance->places[v[i]]
                                          : m34_point(instance->world_from_mesh,
                                                      v3_loadf(mesh->positions[v[i]]));
        if (meets_triangle(world, corners))
            return true;
    }
    return false;
}

static bool meets_instance(const struct segment *world, const struct exact_instance *instance)
{
    const struct clusters *mesh = instance->clusters;
    struct segment s = segment_make(m34_point(instance->mesh_from_world, world->p),
                                    m34_vector(instance->mesh_from_world, world->e),
                                    instance->places ? 1e-6 : 1e-12);
    for (size_t i = 0; i < mesh->node_count;) {
        const struct cluster_node *node = &mesh->nodes[i];
        if (!meets_box(&s, v3_loadf(node->low), v3_loadf(node->high))) {
            i = node->next;
            continue;
        }
        if (node->count == 1 && meets_cluster(world, instance, node->first))
            return true;
        i++;
    }
    return false;
}

bool exact_point_seen(const struct exact_scene *scene, vec3 p, vec3 light)
{
    vec3 e = v3_sub(light, p);
    struct segment world = segment_make(p, e, 1e-6);
    for (size_t i = 0; i < scene->instance_count; i++) {
        const struct exact_bounds *group = &scene->groups[i / EXACT_GROUP];
        if (i % EXACT_GROUP == 0 && !meets_box(&world, group->low, group->high)) {
            i += EXACT_GROUP - 1;
            continue;
        }
        const struct exact_instance *instance = &scene->instances[i];
        if (meets_box(&world, instance->bounds.low, instance->bounds.high) &&
            meets_instance(&world, instance))
            return false;
    }
    return true;
}
