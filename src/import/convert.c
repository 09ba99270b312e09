/* import/convert.c: assimp's scene into the stream.
 *
 * Triangulated; points and lines are dropped and counted in a note. Meshes are written once, in
 * mesh space, and placed by an object for each node that shows them. Nothing that assimp hands over
 * is believed: indices are checked before they are used, so a file that makes it go wrong is named,
 * not followed. Positions that are not finite are passed on: the library names them. */
#include "import/import.h"

#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <strings.h>

#include <penumbra/light.h>

#define NODE_DEPTH_MAX 500
#define COMPLAINTS_MAX 8
#define NO_MESH        0xffffffffu

struct conversion {
    const struct aiScene *scene;
    json_t *gltf;
    char file_name[IMPORT_TEXT_MAX]; /* without folder and ending */
    uint32_t *mesh_in_stream;        /* by assimp's index; NO_MESH: no triangles in it */
    bool facet_normals;              /* the format's normals are those of its triangles */
    size_t objects, points, lines, polygons;
    size_t complaints;      /* of assimp's log */
    char out_of_range[200]; /* the first of them that says so, or "" */
};

void matrix_multiply(const double *a, const double *b, double *out)
{
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 4; column++) {
            double sum = column == 3 ? a[4 * row + 3] : 0;
            for (int k = 0; k < 3; k++)
                sum += a[4 * row + k] * b[4 * k + column];
            out[4 * row + column] = sum;
        }
}

/* Assimp's matrices are row-major already. out = parent x local. */
static void place_node(const double *parent, const struct aiMatrix4x4 *m, double *out)
{
    const double local[12] = {m->a1, m->a2, m->a3, m->a4, m->b1, m->b2,
                              m->b3, m->b4, m->c1, m->c2, m->c3, m->c4};
    matrix_multiply(parent, local, out);
}

/* w: 1 for points, 0 for directions. */
static void transform(const double *m, const struct aiVector3D *v, double w, double *out)
{
    for (int row = 0; row < 3; row++)
        out[row] =
            m[4 * row] * v->x + m[4 * row + 1] * v->y + m[4 * row + 2] * v->z + w * m[4 * row + 3];
}

static bool normalize(double *v)
{
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    if (!(length > 0) || !isfinite(length))
        return false;
    for (int c = 0; c < 3; c++)
        v[c] /= length;
    return true;
}

/* The file's own name in place of none, and of those that assimp makes up. */
static const char *given_name(const struct conversion *conversion, const char *name)
{
    bool made_up = name[0] == 0 || name[0] == '<' || strcmp(name, "defaultobject") == 0;
    return made_up ? conversion->file_name : name;
}

/* Returns false if the mesh has no triangles. */
static bool write_mesh(struct conversion *conversion, const struct aiMesh *mesh)
{
    const char *name = given_name(conversion, mesh->mName.data);
    size_t vertex_count = mesh->mNumVertices, triangle_count = 0;
    for (size_t i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        triangle_count += face->mNumIndices == 3;
        conversion->points += face->mNumIndices == 1;
        conversion->lines += face->mNumIndices == 2;
        conversion->polygons += face->mNumIndices > 3;
    }
    if (triangle_count == 0 || !mesh->mVertices)
        return false;
    if (triangle_count > UINT32_MAX / 3)
        import_fail(IMPORT_BAD_FILE, "mesh '%s' has more than %u triangles", name, UINT32_MAX / 3);

    uint32_t *indices = import_alloc(triangle_count, 3 * sizeof(*indices));
    size_t used = 0;
    for (size_t i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        if (face->mNumIndices != 3)
            continue;
        for (int corner = 0; corner < 3; corner++) {
            if (face->mIndices[corner] >= vertex_count)
                import_fail(IMPORT_BAD_FILE, "mesh '%s': triangle %zu refers to vertex %u of %zu",
                            name, i, face->mIndices[corner], vertex_count);
            indices[used++] = face->mIndices[corner];
        }
    }

    _Static_assert(sizeof(struct aiVector3D) == 12, "assimp with single precision");
    const float *normals = mesh->mNormals && !conversion->facet_normals ? &mesh->mNormals->x : NULL;
    size_t room = vertex_count < used ? vertex_count : used;
    float *kept_positions = import_alloc(room, 12);
    float *kept_normals = normals ? import_alloc(room, 12) : NULL;
    size_t kept = weld_vertices(&mesh->mVertices->x, normals, vertex_count, indices, used,
                                kept_positions, kept_normals);

    writer_record(IMPORT_MESH, writer_text_size(name) + 12 + kept * 12 * (normals ? 2 : 1) +
                                   triangle_count * 12);
    writer_text(name);
    writer_u32((uint32_t)kept);
    writer_u32((uint32_t)triangle_count);
    writer_u32(normals ? IMPORT_HAS_NORMALS : 0);
    writer_bytes(kept_positions, kept * 12);
    if (normals)
        writer_bytes(kept_normals, kept * 12);
    writer_bytes(indices, triangle_count * 12);
    import_free(indices);
    import_free(kept_positions);
    import_free(kept_normals);
    return true;
}

static void material_colors(const struct conversion *conversion, unsigned index, double *color,
                            double *emission, bool *double_sided)
{
    color[0] = color[1] = color[2] = 0.8;
    emission[0] = emission[1] = emission[2] = 0;
    *double_sided = false;
    if (index >= conversion->scene->mNumMaterials)
        return;
    const struct aiMaterial *material = conversion->scene->mMaterials[index];
    struct aiString name = {0};
    struct aiColor4D value;
    int two_sided = 0;
    aiGetMaterialString(material, AI_MATKEY_NAME, &name);
    bool given = strcmp(name.data, AI_DEFAULT_MATERIAL_NAME) != 0; /* else: put there by assimp */
    if (given &&
        (aiGetMaterialColor(material, AI_MATKEY_BASE_COLOR, &value) == aiReturn_SUCCESS ||
         aiGetMaterialColor(material, AI_MATKEY_COLOR_DIFFUSE, &value) == aiReturn_SUCCESS)) {
        color[0] = value.r, color[1] = value.g, color[2] = value.b;
    }
    if (given &&
        aiGetMaterialColor(material, AI_MATKEY_COLOR_EMISSIVE, &value) == aiReturn_SUCCESS) {
        float strength = 1;
        if (conversion->gltf)
            strength = (float)gltf_emissive_strength(conversion->gltf, index);
        else
            aiGetMaterialFloatArray(material, AI_MATKEY_EMISSIVE_INTENSITY, &strength, NULL);
        emission[0] = (double)value.r * strength;
        emission[1] = (double)value.g * strength;
        emission[2] = (double)value.b * strength;
    }
    if (aiGetMaterialIntegerArray(material, AI_MATKEY_TWOSIDED, &two_sided, NULL) ==
        aiReturn_SUCCESS)
        *double_sided = two_sided != 0;
}

/* json: the node in a glTF file, or NULL: unknown. Assimp keeps the order of glTF's nodes, and puts
 * one above them where the scene has several roots; so both trees are walked side by side. */
static void write_objects(struct conversion *conversion, const struct aiNode *node, json_t *json,
                          const double *parent, int depth)
{
    if (depth > NODE_DEPTH_MAX)
        import_fail(IMPORT_BAD_FILE, "nodes are nested more than %d deep", NODE_DEPTH_MAX);
    double world_from_mesh[12];
    place_node(parent, &node->mTransformation, world_from_mesh);
    for (unsigned i = 0; i < node->mNumMeshes; i++) {
        unsigned index = node->mMeshes[i];
        if (index >= conversion->scene->mNumMeshes)
            import_fail(IMPORT_BAD_FILE, "node '%s' refers to mesh %u of %u", node->mName.data,
                        index, conversion->scene->mNumMeshes);
        uint32_t mesh = conversion->mesh_in_stream[index];
        if (mesh == NO_MESH)
            continue;
        const char *name = given_name(conversion, node->mName.data);
        double numbers[IMPORT_OBJECT_NUMBERS];
        bool double_sided;
        memcpy(numbers, world_from_mesh, sizeof(world_from_mesh));
        material_colors(conversion, conversion->scene->mMeshes[index]->mMaterialIndex, numbers + 12,
                        numbers + 15, &double_sided);
        writer_record(IMPORT_OBJECT, writer_text_size(name) + 8 + sizeof(numbers));
        writer_text(name);
        writer_u32(mesh);
        writer_u32((double_sided ? IMPORT_DOUBLE_SIDED : 0) | gltf_object_flags(json));
        writer_numbers(numbers, IMPORT_OBJECT_NUMBERS);
        conversion->objects++;
    }
    for (unsigned i = 0; i < node->mNumChildren; i++)
        write_objects(conversion, node->mChildren[i],
                      gltf_child(conversion->gltf, json, depth == 0, i, node->mNumChildren),
                      world_from_mesh, depth + 1);
}

static const double identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};

/* The node that carries a camera or a light, by its name. */
static const struct aiNode *find_node(const struct aiNode *node, const double *parent,
                                      const char *name, double *world, int depth)
{
    place_node(parent, &node->mTransformation, world);
    if (strcmp(node->mName.data, name) == 0)
        return node;
    double here[12];
    memcpy(here, world, sizeof(here));
    for (unsigned i = 0; i < node->mNumChildren && depth < NODE_DEPTH_MAX; i++) {
        const struct aiNode *found = find_node(node->mChildren[i], here, name, world, depth + 1);
        if (found)
            return found;
    }
    return NULL;
}

static void write_camera(const struct conversion *conversion, const struct aiCamera *camera)
{
    double world[12], numbers[IMPORT_CAMERA_NUMBERS];
    if (!find_node(conversion->scene->mRootNode, identity, camera->mName.data, world, 0))
        memcpy(world, identity, sizeof(identity));
    transform(world, &camera->mPosition, 1, numbers);
    transform(world, &camera->mLookAt, 0, numbers + 3);
    transform(world, &camera->mUp, 0, numbers + 6);
    /* The whole horizontal angle; pictures without a stated aspect are taken as 4:3. */
    double aspect = camera->mAspect > 0 ? camera->mAspect : 4.0 / 3.0;
    numbers[9] = atan(tan(0.5 * camera->mHorizontalFOV) / aspect) * 360 / 3.14159265358979323846;
    if (!normalize(numbers + 3) || !normalize(numbers + 6) || !(numbers[9] > 0) ||
        numbers[9] >= 180) {
        writer_note("camera '%s' means nothing and is left out", camera->mName.data);
        return;
    }
    writer_camera(camera->mName.data, numbers);
}

static void write_light(const struct conversion *conversion, const struct aiLight *light)
{
    const char *name = light->mName.data;
    double world[12], numbers[IMPORT_LIGHT_NUMBERS] = {0}, *shape = numbers + 3, direction[3];
    if (!find_node(conversion->scene->mRootNode, identity, name, world, 0))
        memcpy(world, identity, sizeof(identity));
    numbers[0] = light->mColorDiffuse.r;
    numbers[1] = light->mColorDiffuse.g;
    numbers[2] = light->mColorDiffuse.b;
    if (!(numbers[0] > 0 || numbers[1] > 0 || numbers[2] > 0)) {
        writer_note("light '%s' is black and is left out", name);
        return;
    }
    transform(world, &light->mPosition, 1, shape);
    transform(world, &light->mDirection, 0, direction);
    bool directed = normalize(direction);
    switch (light->mType) {
    case aiLightSource_SPOT:
        writer_note("light '%s': a spot light is taken as a point light", name);
        /* fall through */
    case aiLightSource_POINT: writer_light(name, PNB_LIGHT_POINT, numbers); return;
    case aiLightSource_DIRECTIONAL:
        if (!directed)
            break;
        memcpy(shape, direction, sizeof(direction));
        shape[3] = 0.53;
        writer_note("light '%s': a directional light is taken as a sun of 0.53 degrees", name);
        writer_light(name, PNB_LIGHT_SUN, numbers);
        return;
    case aiLightSource_AREA: {
        /* A rectangle along up and direction x up. */
        double up[3], across[3], scale;
        transform(world, &light->mUp, 0, up);
        scale = sqrt(world[0] * world[0] + world[4] * world[4] + world[8] * world[8]);
        double along = up[0] * direction[0] + up[1] * direction[1] + up[2] * direction[2];
        for (int c = 0; c < 3; c++)
            up[c] -= along * direction[c];
        if (!directed || !normalize(up))
            break;
        for (int c = 0; c < 3; c++) /* across x up = direction */
            across[c] =
                up[(c + 1) % 3] * direction[(c + 2) % 3] - up[(c + 2) % 3] * direction[(c + 1) % 3];
        for (int c = 0; c < 3; c++) {
            shape[3 + c] = across[c] * 0.5 * scale * light->mSize.x;
            shape[6 + c] = up[c] * 0.5 * scale * light->mSize.y;
        }
        writer_light(name, PNB_LIGHT_RECTANGLE, numbers);
        return;
    }
    default: break;
    }
    writer_note("light '%s': its kind is not supported, it is left out", name);
}

static void write_dropped(const struct conversion *conversion)
{
    const struct aiScene *scene = conversion->scene;
    size_t textured = 0, glowing = 0;
    if (conversion->points > 0 || conversion->lines > 0)
        writer_note("%zu points and %zu lines are left out: only triangles are read",
                    conversion->points, conversion->lines);
    if (conversion->polygons > 0)
        writer_note("%zu polygons could not be cut into triangles and are left out",
                    conversion->polygons);
    for (unsigned i = 0; i < scene->mNumMaterials; i++) {
        const struct aiMaterial *material = scene->mMaterials[i];
        textured += aiGetMaterialTextureCount(material, aiTextureType_DIFFUSE) > 0 ||
                    aiGetMaterialTextureCount(material, aiTextureType_BASE_COLOR) > 0;
        glowing += aiGetMaterialTextureCount(material, aiTextureType_EMISSIVE) > 0;
    }
    if (textured > 0)
        writer_note("textures are not read: %zu materials show their base colour only", textured);
    if (glowing > 0)
        writer_note("emissive textures are not read: %zu materials emit evenly", glowing);
}

static const char *file_ending(const char *path)
{
    const char *dot = strrchr(path, '.'), *slash = strrchr(path, '/');
    return dot && (!slash || dot > slash) ? dot : "";
}

/* Assimp mends some files silently; what it logs as an error is passed on. An index out of range is
 * no small matter: then the shape is not what the file says. */
static void hear(const char *line, char *user)
{
    struct conversion *conversion = (struct conversion *)user;
    const char *colon = strchr(line, ':');
    if (strncmp(line, "Error", 5) != 0 || !colon)
        return;
    const char *message = colon + 1 + strspn(colon + 1, " ");
    int length = (int)strcspn(message, "\n");
    if (conversion->complaints++ < COMPLAINTS_MAX)
        writer_note("while reading: %.*s", length, message);
    if (strstr(message, "out of range") && !conversion->out_of_range[0])
        snprintf(conversion->out_of_range, sizeof(conversion->out_of_range), "%.*s", length,
                 message);
}

void convert_file(const char *path, json_t *gltf)
{
    struct conversion conversion = {.gltf = gltf};
    const char *ending = file_ending(path), *slash = strrchr(path, '/');
    const char *base = slash ? slash + 1 : path;
    size_t length = strlen(base) - strlen(ending);
    if (length >= sizeof(conversion.file_name))
        length = sizeof(conversion.file_name) - 1;
    memcpy(conversion.file_name, base, length);
    conversion.facet_normals = strcasecmp(ending, ".stl") == 0;

    /* Only triangulation: the reader's own welding takes three times as long as ours. */
    struct aiLogStream log = {hear, (char *)&conversion};
    aiAttachLogStream(&log);
    const struct aiScene *scene = aiImportFile(path, aiProcess_Triangulate);
    if (!scene || !scene->mRootNode) {
        const char *why = aiGetErrorString();
        if (strstr(why, "bad_alloc") || strstr(why, "bad allocation"))
            import_fail(IMPORT_NO_MEMORY, "out of memory");
        if (!*why || strncmp(why, "No suitable reader", 18) == 0)
            why = "its content is not what its ending says";
        import_fail(IMPORT_BAD_FILE, "%s", why);
    }
    if (conversion.out_of_range[0])
        import_fail(IMPORT_BAD_FILE, "%s", conversion.out_of_range);
    conversion.scene = scene;
    conversion.mesh_in_stream = import_alloc(scene->mNumMeshes, sizeof(uint32_t));
    uint32_t written = 0;
    for (unsigned i = 0; i < scene->mNumMeshes; i++)
        conversion.mesh_in_stream[i] =
            write_mesh(&conversion, scene->mMeshes[i]) ? written++ : NO_MESH;
    write_objects(&conversion, scene->mRootNode, gltf_root(gltf), identity, 0);

    if (gltf) {
        gltf_write_surroundings(gltf);
        gltf_write_cameras_and_lights(gltf);
    } else {
        for (unsigned i = 0; i < scene->mNumCameras; i++)
            write_camera(&conversion, scene->mCameras[i]);
        for (unsigned i = 0; i < scene->mNumLights; i++)
            write_light(&conversion, scene->mLights[i]);
    }
    write_dropped(&conversion);
}
