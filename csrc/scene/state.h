/* What the files of this room share: the scene's parts as the messages brought them, and what scene_commit
   makes of them. */
#ifndef SCENE_STATE_H
#define SCENE_STATE_H

#include "material/hit_mesh.h"
#include "material/volume.h"
#include "scene/build.h"
#include "scene/registry.h"

/* --- Geometry ---------------------------------------------------------------------------------------- */

struct mesh {
    struct hit_mesh hit; /* what hits point to */
    char *name;
    float *positions; /* 3 per vertex; one vertex of padding, because Embree reads 16 bytes at each */
    uint32_t *triangles, *corners; /* 3 per triangle; corners may be NULL */
    float *normals;                /* 3 per corner, or NULL: flat */
    struct mesh_uv *uv;            /* their data is owned */
    float *tangents; /* 3 per corner of each triangle; NULL: flat, or no normal map needs them (tangents.c) */
    uint32_t *material_index; /* per triangle, or NULL: all 0 */
    size_t vertex_count, triangle_count, corner_count, uv_count;
    struct vec3 low, high;  /* bounding box */
    const float **uv_table; /* hit.uv; borrowed pointers into uv[] */
    void *structure; /* this mesh's own acceleration structure (embree.c), NULL until an instance needs it */
};
void mesh_destroy(struct mesh *);
/* Points hit.uv at the layers by their names: entry i + 1 is the layer called names[i]. */
bool mesh_resolve_uv(struct mesh *, char *const *names, uint32_t count);

/* Smooth tangents, if the mesh is smooth and has texture coordinates. False: no memory. */
bool mesh_build_tangents(struct mesh *);

/* Emissive triangles of one material slot, for drawing one by area. */
struct triangle_cdf {
    uint32_t *triangle;
    double *sum; /* count + 1 entries; sum[count] is the whole area */
    uint32_t count;
};

struct instances {
    char *name, *mesh_name;
    char **material_names;
    size_t material_count;
    struct transform *transforms;
    size_t transform_count;
    uint32_t mask; /* enum ray_kind */
    bool holdout;
    /* Resolved by scene_commit; slot_count ≥ 1. */
    const struct mesh *mesh;
    const struct material **materials;
    int *emitter;             /* per slot: which of an object's lights it is, or −1 */
    struct triangle_cdf *cdf; /* per slot: areas in the mesh's own space */
    size_t slot_count, emitter_count;
};
void instances_destroy(struct instances *);
void instances_forget(struct instances *); /* drops what scene_commit resolved */

/* One placed mesh. Its index in scene.objects is hit.instance and Embree's geometry id. */
struct object {
    struct transform to_world, to_local; /* to_local only where instanced */
    const struct mesh *mesh;
    const struct instances *instances;
    int first_light; /* of its emitters; −1: none */
    bool mirrored;   /* negative determinant */
    bool flattened;  /* its triangles lie in the top structure, in world space */
    bool vanished;   /* scaled to nothing: no ray meets it */
};
bool scene_build_objects(struct scene *, stokes_error *err);
static inline size_t object_slot(const struct object *object, uint32_t triangle)
{
    size_t slot = object->mesh->material_index ? object->mesh->material_index[triangle] : 0;
    return slot < object->instances->slot_count ? slot : object->instances->slot_count - 1;
}
/* The hit at barycentric coordinates of a triangle of object `index`. */
void scene_fill_hit(const struct scene *, uint32_t index, uint32_t triangle, float u, float v, struct hit *);
/* A triangle's corners in the mesh's own space. */
void mesh_triangle(const struct mesh *, uint32_t triangle, struct vec3 corner[3]);
/* A triangle's doubled vector area, and its length, after a transform (NULL: none). */
double triangle_area(const struct mesh *, const struct transform *, uint32_t triangle);

/* --- Materials and images ---------------------------------------------------------------------------- */

struct material_slot {
    char *name;
    struct closure *closure; /* until it is compiled */
    struct volume *volume;   /* NULL: none */
    struct material *compiled;
    bool needs_table, has_normal_map, failed;
    stokes_error error; /* why it failed */
};
void material_slot_destroy(struct material_slot *);

/* --- Volumes ----------------------------------------------------------------------------------------- */

/* Volumes that a ray enters (+) and leaves (−), summed up: media.c. */
#define BOUNDARIES_MAX 16
struct boundaries {
    int count;
    struct boundary {
        int volume, times;
        double sum; /* of the distances, with their signs */
    } at[BOUNDARIES_MAX];
};
void boundaries_meet(struct boundaries *, int volume, bool enters, double t);

/* Volumes that materials and the world have; the world's is the first. */
struct volumes {
    const struct volume **list; /* borrowed */
    int count;
    bool world, bounded; /* in use */
    bool camera_inside;  /* camera rays may start inside of some body's bounding box */
};
bool scene_list_volumes(struct scene *, stokes_error *err);
void scene_place_camera(struct scene *);

/* A segment's far end may lie on a surface whose test rounds by the segment's length, which its offset knows nothing of. */
extern const float scene_segment_end;

/* --- Lights ------------------------------------------------------------------------------------------ */

/* Spectral radiance, intensity or irradiance of a light that is not a mesh: a spectrum, or a texture. */
struct emission {
    const struct spectrum *fixed;
    const struct texture *texture; /* NULL: `fixed` */
    float scale;                   /* of the texture */
    const struct rgb_table *table;
    const struct spectrum *illuminant; /* scene.illuminant */
    const struct spectrum *shape;      /* wavelengths are drawn from it: positive wherever the light emits */
    struct spectrum *own_shape;        /* of a texture */
    double total;                      /* ∫ of the mean over Λ */
    bool out_of_reach;                 /* no reflectance has the mean colour of the texture */
};
/* `mean` is the texture's mean colour over what it lights. */
bool emission_compile(struct emission *, const struct scene *, const struct emission_node *,
                      const float mean[3], const char *name, stokes_error *err);
float emission_at(const struct emission *, struct vec3 coordinates, float lambda);
void emission_free(struct emission *);
/* The working space's white, scaled to Y = 1 on the film: D65/∫D65 over Λ, or another daylight. Yours. */
struct spectrum *emission_white(const struct scene *);

struct lamp {
    char *name;
    struct light_input input; /* name and emission are owned here */
    uint32_t mask;
    struct emission emission;
    /* Derived from shape and transform. */
    struct vec3 center, axis_u, axis_v, dual_u, dual_v,
        normal;                /* full edges of the rectangle; duals of the edges */
    struct transform to_local; /* of a spot's directions */
    float determinant, area, cos_half, smooth, half_angle;
};
bool lamp_derive(struct lamp *, stokes_error *err);
void lamp_destroy(struct lamp *);

struct world_map; /* importance of a world image */
struct world {
    struct world_input input; /* image name owned */
    char *image_name;
    uint32_t mask;
    struct transform from_map;
    float determinant;         /* of to_map */
    struct emission_node node; /* of an image world */
    struct texture texture;
    struct emission emission;
    struct world_map *map;
};
void world_destroy(struct world *);
bool world_compile(struct scene *, stokes_error *err);
/* Density per solid angle of a direction from the scene to the world. */
float world_pdf(const struct world *, struct vec3 direction);
struct vec3 world_sample(const struct world *, const float u[2]);
float world_radiance(const struct world *, struct vec3 direction, float lambda);

struct light_kind;
struct light {
    const struct light_kind *kind;
    const char *name;
    const struct spectrum *spectrum; /* shared by all of its shape */
    uint32_t shape;                  /* index into scene.spectra */
    double total;                    /* ∫ of the light's own mean spectrum over Λ */
    double power, probability;
    uint32_t mask;
    const struct lamp *lamp;        /* of lamps */
    uint32_t object, slot;          /* of mesh emitters */
    const struct triangle_cdf *cdf; /* of mesh emitters */
    struct triangle_cdf *own_cdf;   /* of objects whose transform does not keep the ratios of areas */
};

/* What kinds of lights differ in; see scene.h for measures. `choice` is a third uniform number. */
struct light_kind {
    bool delta, distant, has_normal;
    double (*power)(const struct scene *, const struct light *);
    float (*sample_point)(const struct scene *, const struct light *, double choice, const float u[2],
                          struct light_point *);
    float (*pdf_point)(const struct scene *, const struct light *, const struct light_point *);
    float (*sample_direction)(const struct scene *, const struct light *, const struct light_point *,
                              const float u[2],
                              struct vec3 *direction); /* 0: this draw fails; NULL for distant lights */
    float (*pdf_direction)(const struct scene *, const struct light *, const struct light_point *,
                           struct vec3 direction);
    float (*emission)(const struct scene *, const struct light *, const struct light_point *,
                      struct vec3 direction, float lambda);
    /* Where a ray meets a lamp's lit side, or sees a distant light; NULL: never. *t is the distance. */
    bool (*hit)(const struct scene *, const struct light *, const struct ray *, struct light_point *,
                float *t);
};
extern const struct light_kind light_mesh, light_rectangle, light_ellipse, light_sphere, light_point_lamp,
    light_spot, light_spot_sphere, light_sun, light_sun_delta, light_world;

/* Makes the table of lights from emissive objects, lamps and the world; then the choice among them. */
bool scene_build_lights(struct scene *, stokes_error *err);
/* Lets lights of one spectral shape share it. False: no memory. */
bool scene_share_spectra(struct scene *);
bool scene_weigh_lights(struct scene *, stokes_error *err);
void scene_free_lights(struct scene *);
/* Index of the entry of an ascending sum[count + 1] that x·sum[count] falls into, and where in it, 0 … 1. */
size_t search_sum(const double *sum, size_t count, double x, double *rest);
bool triangle_cdf_build(struct triangle_cdf *, const struct instances *, const struct mesh *,
                        const struct transform *, size_t slot);
void triangle_cdf_free(struct triangle_cdf *);

/* --- Camera ------------------------------------------------------------------------------------------ */

struct camera {
    struct camera_input input;
    struct vec3 x, y, axis, position; /* axis: viewing direction */
    float width, height;              /* of the frame */
    struct hit_window window;
};
void camera_destroy(struct camera *);

/* --- The scene --------------------------------------------------------------------------------------- */

struct accel; /* embree.c */
struct accel *accel_create(int threads, stokes_error *err);
void accel_destroy(struct accel *);
void accel_release(void *structure); /* a mesh's */
/* Builds the structures of instanced meshes that have none, and the top one. Meshes are the scene's. */
bool accel_build(struct scene *, const struct scene_setup *, stokes_error *err);
bool accel_build_lamps(struct scene *, stokes_error *err);
struct accel_hit {
    uint32_t object, primitive;
    float u, v, t;
};
bool accel_intersect(const struct scene *, const struct ray *, struct accel_hit *);
/* `boundaries` (may be NULL) is told of each volume that the ray enters or leaves, at distances in metres. */
float accel_transmittance(const struct scene *, struct vec3 origin, struct vec3 direction, float far,
                          float lambda, uint32_t kind, struct boundaries *);
/* Whether a ray of this kind meets anything at all, transparent or not. */
bool accel_meets(const struct scene *, struct vec3 origin, struct vec3 direction, float far, uint32_t kind);
/* All boundaries of volumes along an endless ray, whatever else is in its way. */
void accel_boundaries(const struct scene *, struct vec3 origin, struct vec3 direction, struct boundaries *);
/* Bounding box of a lamp that can be hit. */
void lamp_bounds(const struct lamp *, struct vec3 *low, struct vec3 *high);
/* A collection of the lamps on a ray, nearest first. */
struct lamp_hits {
    const struct scene *scene;
    const struct ray *ray;
    struct light_point *point;
    float t[64];
    int count, most;
};
void lamp_hits_try(struct lamp_hits *, int light);
void accel_lamps(const struct scene *, struct lamp_hits *);

struct scene {
    struct registry meshes, materials, images, instances, lamps;
    struct image **retired; /* removed images that materials may still look up */
    size_t retired_count;
    struct world *world;
    struct camera *camera;
    bool geometry_dirty, materials_dirty, images_dirty, lights_dirty, camera_dirty;

    /* What scene_commit makes. */
    bool committed;
    struct material_context context;
    struct rgb_table *rgb_table;
    struct spectrum *illuminant; /* emission_white; NULL while no texture emits */
    struct material *default_material;
    char **uv_names;
    uint32_t uv_name_count;
    struct object *objects;
    size_t object_count;
    bool laid_out; /* objects have been built before */
    struct accel *accel;
    bool transparent; /* some material in use may be */
    bool mixed;       /* some object is SEEN_BY_SOME */
    struct volumes volumes;
    struct vec3 center;
    float radius;
    struct light *lights;
    size_t light_count, lost_count; /* lost: at infinity, where the world's volume lets nothing through */
    double *light_sum;
    const struct spectrum **spectra; /* distinct shapes of lights' spectra; borrowed from their lights */
    size_t spectrum_count;
    int *hittable, *distant; /* indices of lamps that rays can hit, of distant lights that they can see */
    size_t hittable_count, distant_count;
    struct spectrum *lamp_spectrum;
    struct material **fluorophore_material; /* by fluorophore */
    int *fluorophore_first, fluorophore_count;
};

char *copy_text(const char *text);
static inline uint32_t visibility_mask(struct visibility visible)
{
    const uint32_t between = RAY_DIFFUSE | RAY_GLOSSY | RAY_TRANSMISSION | RAY_VOLUME;
    uint32_t kinds = (visible.camera ? RAY_CAMERA : 0) | (visible.diffuse ? RAY_DIFFUSE : 0) |
                     (visible.glossy ? RAY_GLOSSY : 0) | (visible.transmission ? RAY_TRANSMISSION : 0) |
                     (visible.shadow ? RAY_SHADOW : 0) | (visible.volume ? RAY_VOLUME : 0);
    bool some = (kinds & (between | RAY_CAMERA)) && (kinds & between) != between;
    return kinds | (some ? SEEN_BY_SOME : 0);
}
double transform_determinant(const struct transform *);
/* False if it is singular. */
bool transform_inverse(const struct transform *, struct transform *inverse);
bool transform_is_finite(const struct transform *);

#endif
