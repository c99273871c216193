/* Ray tracing: the one file that knows Embree (3.13's C API). Geometry ids are indices of scene.objects; user
   geometry in a second structure holds the lamps that rays can hit. */
#include <embree3/rtcore.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

struct accel {
    RTCDevice device;
    RTCScene top, lamps; /* NULL where there is nothing */
};

struct accel *accel_create(int threads, stokes_error *err)
{
    char settings[32];
    snprintf(settings, sizeof settings, "threads=%d", threads > 0 ? threads : 0);
    struct accel *accel = calloc(1, sizeof *accel);
    if (accel)
        accel->device = rtcNewDevice(settings);
    if (!accel || !accel->device ||
        !rtcGetDeviceProperty(accel->device, RTC_DEVICE_PROPERTY_RAY_MASK_SUPPORTED) ||
        !rtcGetDeviceProperty(accel->device, RTC_DEVICE_PROPERTY_FILTER_FUNCTION_SUPPORTED)) {
        accel_destroy(accel);
        fail(err, "scene", "embree",
             "this Embree does not start, or was built without ray masks or filter functions");
        return NULL;
    }
    return accel;
}

void accel_release(void *structure)
{
    if (structure)
        rtcReleaseScene(structure);
}

void accel_destroy(struct accel *accel)
{
    if (!accel)
        return;
    accel_release(accel->top);
    accel_release(accel->lamps);
    if (accel->device)
        rtcReleaseDevice(accel->device);
    free(accel);
}

static bool device_is_well(RTCDevice device, stokes_error *err)
{
    switch (rtcGetDeviceError(device)) {
    case RTC_ERROR_NONE: return true;
    case RTC_ERROR_OUT_OF_MEMORY:
        return fail(err, "scene", "embree", "no memory for the acceleration structure");
    case RTC_ERROR_UNKNOWN:
    case RTC_ERROR_INVALID_ARGUMENT:
    case RTC_ERROR_INVALID_OPERATION:
    case RTC_ERROR_UNSUPPORTED_CPU: break;
    case RTC_ERROR_CANCELLED: return fail(err, "scene", "embree", "cancelled");
    }
    return fail(err, "scene", "embree", "the acceleration structure could not be built");
}

/* --- Building ---------------------------------------------------------------------------------------- */

static void attach(RTCScene scene, RTCGeometry geometry, uint32_t mask, uint32_t id)
{
    rtcSetGeometryMask(geometry, mask);
    rtcCommitGeometry(geometry);
    rtcAttachGeometryByID(scene, geometry, id);
    rtcReleaseGeometry(geometry);
}

/* Triangles that share the mesh's arrays; with a transform, its vertices in world space. */
static RTCGeometry mesh_geometry(RTCDevice device, const struct mesh *mesh, const struct transform *transform)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
    rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh->triangles, 0,
                               3 * sizeof(uint32_t), mesh->triangle_count);
    if (!transform) {
        rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh->positions, 0,
                                   3 * sizeof(float), mesh->vertex_count);
        return geometry;
    }
    float *world = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                           3 * sizeof(float), mesh->vertex_count);
    for (size_t i = 0; world && i < mesh->vertex_count; i++) {
        const float *p = mesh->positions + 3 * i;
        struct vec3 q = transform_point(transform, vec3(p[0], p[1], p[2]));
        memcpy(world + 3 * i, &q, 3 * sizeof(float));
    }
    return geometry;
}

/* No HIGH quality: its spatial splits would show a triangle twice to the filter that multiplies
   transmittances. */
static RTCScene new_scene(RTCDevice device)
{
    RTCScene scene = rtcNewScene(device);
    rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
    rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
    return scene;
}

static bool go_on(void *setup, double built)
{
    const struct scene_setup *of = setup;
    (void)built;
    return !of->stop || !of->stop(of->user);
}

static bool build(RTCScene scene, RTCDevice device, const struct scene_setup *setup, stokes_error *err)
{
    struct scene_setup asked = *setup; /* Embree takes no pointer to const */
    if (!go_on(&asked, 0))
        return fail(err, "scene", "embree", "cancelled");
    rtcSetSceneProgressMonitorFunction(scene, go_on, &asked);
    rtcCommitScene(scene);
    rtcSetSceneProgressMonitorFunction(scene, NULL, NULL);
    return device_is_well(device, err);
}

static RTCGeometry instance_geometry(RTCDevice device, const struct object *object)
{
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(geometry, object->mesh->structure);
    rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_ROW_MAJOR, object->to_world.m);
    return geometry;
}

static bool build_mesh_structure(struct mesh *mesh, RTCDevice device, const struct scene_setup *setup,
                                 stokes_error *err)
{
    RTCScene scene = new_scene(device);
    attach(scene, mesh_geometry(device, mesh, NULL), UINT32_MAX, 0);
    if (!build(scene, device, setup, err)) {
        accel_release(scene);
        return false;
    }
    mesh->structure = scene;
    return true;
}

static bool build_mesh_structures(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    for (size_t i = 0; i < scene->object_count; i++) {
        const struct object *object = &scene->objects[i];
        if (object->flattened || object->vanished || object->mesh->structure)
            continue;
        struct mesh *mesh = registry_find(&scene->meshes, object->mesh->name);
        if (!build_mesh_structure(mesh, scene->accel->device, setup, err))
            return false;
    }
    return true;
}

bool accel_build(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    RTCDevice device = scene->accel->device;
    if (!build_mesh_structures(scene, setup, err))
        return false;
    accel_release(scene->accel->top);
    scene->accel->top = new_scene(device);
    for (size_t i = 0; i < scene->object_count; i++) {
        const struct object *object = &scene->objects[i];
        if (object->vanished)
            continue;
        RTCGeometry geometry = object->flattened ? mesh_geometry(device, object->mesh, &object->to_world)
                                                 : instance_geometry(device, object);
        attach(scene->accel->top, geometry, object->instances->mask, (uint32_t)i);
    }
    return build(scene->accel->top, device, setup, err);
}

/* --- Surfaces ---------------------------------------------------------------------------------------- */

static struct RTCRay embree_ray(struct vec3 origin, struct vec3 direction, float near, float far,
                                uint32_t mask)
{
    return (struct RTCRay){.org_x = origin.x,
                           .org_y = origin.y,
                           .org_z = origin.z,
                           .tnear = near,
                           .dir_x = direction.x,
                           .dir_y = direction.y,
                           .dir_z = direction.z,
                           .tfar = far,
                           .mask = mask};
}

/* The top structure's geometry id is the object, whether the hit lies in an instance or not. */
static uint32_t object_of(uint32_t instance, uint32_t geometry)
{
    return instance != RTC_INVALID_GEOMETRY_ID ? instance : geometry;
}

bool accel_intersect(const struct scene *scene, const struct ray *ray, struct accel_hit *hit)
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    struct RTCRayHit query = {.ray = embree_ray(ray->origin, ray->direction, ray->near, ray->far, ray->kind)};
    query.hit.geomID = query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene->accel->top, &context, &query);
    if (query.hit.geomID == RTC_INVALID_GEOMETRY_ID)
        return false;
    *hit = (struct accel_hit){object_of(query.hit.instID[0], query.hit.geomID), query.hit.primID, query.hit.u,
                              query.hit.v, query.ray.tfar};
    return true;
}

struct shadow_query {
    struct RTCIntersectContext context; /* first: Embree hands back its address */
    const struct scene *scene;
    struct vec3 viewing;
    float lambda, transmittance;
    float stretch; /* metres in a unit of the ray's parameter */
    struct boundaries *boundaries;
};

/* The surface that a filter function is asked about, and the volume behind it. */
struct met {
    uint32_t index;
    const struct RTCHit *found;
    const struct material *material;
};

static struct met met_surface(const struct scene *scene, const struct RTCFilterFunctionNArguments *args)
{
    struct met met = {.found = (const struct RTCHit *)args->hit}; /* N is 1 for rtcOccluded1 */
    met.index = object_of(met.found->instID[0], met.found->geomID);
    const struct object *object = &scene->objects[met.index];
    met.material = object->instances->materials[object_slot(object, met.found->primID)];
    return met;
}

static void tell_boundary(const struct shadow_query *query, const struct RTCFilterFunctionNArguments *args,
                          const struct met *met, const struct hit *hit)
{
    int volume = material_volume(met->material);
    if (volume >= 0)
        boundaries_meet(query->boundaries, volume, dot(query->viewing, hit->ng) > 0,
                        (double)query->stretch * ((const struct RTCRay *)args->ray)->tfar);
}

/* Lets the ray through a surface that transmits some of it, and keeps count. */
static void filter_shadow(const struct RTCFilterFunctionNArguments *args)
{
    struct shadow_query *query = (struct shadow_query *)args->context;
    const struct scene *scene = query->scene;
    struct met met = met_surface(scene, args);
    if (!material_may_be_transparent(met.material))
        return;
    struct hit hit;
    scene_fill_hit(scene, met.index, met.found->primID, met.found->u, met.found->v, &hit);
    query->transmittance *= material_transmittance(met.material, &hit, query->viewing, query->lambda);
    if (!(query->transmittance > 0))
        return;
    args->valid[0] = 0;
    if (query->boundaries)
        tell_boundary(query, args, &met, &hit);
}

/* Lets the ray through everything. */
static void filter_boundaries(const struct RTCFilterFunctionNArguments *args)
{
    const struct shadow_query *query = (const struct shadow_query *)args->context;
    struct met met = met_surface(query->scene, args);
    struct hit hit;
    args->valid[0] = 0;
    if (material_volume(met.material) < 0)
        return;
    scene_fill_hit(query->scene, met.index, met.found->primID, met.found->u, met.found->v, &hit);
    tell_boundary(query, args, &met, &hit);
}

void accel_boundaries(const struct scene *scene, struct vec3 origin, struct vec3 direction,
                      struct boundaries *boundaries)
{
    struct shadow_query query = {
        .scene = scene, .viewing = negate(direction), .stretch = 1, .boundaries = boundaries};
    rtcInitIntersectContext(&query.context);
    query.context.filter = filter_boundaries;
    struct RTCRay ray = embree_ray(origin, direction, 0, INFINITY, UINT32_MAX);
    rtcOccluded1(scene->accel->top, &query.context, &ray);
}

float accel_transmittance(const struct scene *scene, struct vec3 origin, struct vec3 direction, float far,
                          float lambda, uint32_t kind, struct boundaries *boundaries)
{
    struct shadow_query query = {
        .scene = scene, .lambda = lambda, .transmittance = 1, .boundaries = boundaries};
    rtcInitIntersectContext(&query.context);
    if (scene->transparent) {
        query.context.filter = filter_shadow;
        query.viewing = negate(normalize(direction));
        query.stretch = length(direction);
    }
    struct RTCRay ray = embree_ray(origin, direction, 0, far, kind);
    rtcOccluded1(scene->accel->top, &query.context, &ray);
    return ray.tfar < 0 ? 0 : query.transmittance;
}

bool accel_meets(const struct scene *scene, struct vec3 origin, struct vec3 direction, float far,
                 uint32_t kind)
{
    struct RTCIntersectContext context;
    struct RTCRay ray = embree_ray(origin, direction, 0, far, kind);
    rtcInitIntersectContext(&context);
    rtcOccluded1(scene->accel->top, &context, &ray);
    return ray.tfar < 0;
}

/* --- Lamps ------------------------------------------------------------------------------------------- */

struct lamp_query {
    struct RTCIntersectContext context;
    struct lamp_hits *hits;
};

static void bound_lamp(const struct RTCBoundsFunctionArguments *args)
{
    const struct scene *scene = args->geometryUserPtr;
    struct vec3 low, high;
    lamp_bounds(scene->lights[scene->hittable[args->primID]].lamp, &low, &high);
    *args->bounds_o = (struct RTCBounds){.lower_x = low.x,
                                         .lower_y = low.y,
                                         .lower_z = low.z,
                                         .upper_x = high.x,
                                         .upper_y = high.y,
                                         .upper_z = high.z};
}

/* Collects instead of reporting, so that the ray goes on. */
static void intersect_lamp(const struct RTCIntersectFunctionNArguments *args)
{
    const struct scene *scene = args->geometryUserPtr;
    lamp_hits_try(((struct lamp_query *)args->context)->hits, scene->hittable[args->primID]);
}

static void occluded_lamp(const struct RTCOccludedFunctionNArguments *args)
{
    (void)args; /* lamps block nothing */
}

bool accel_build_lamps(struct scene *scene, stokes_error *err)
{
    RTCDevice device = scene->accel->device;
    accel_release(scene->accel->lamps);
    scene->accel->lamps = NULL;
    if (!scene->hittable_count)
        return true;
    scene->accel->lamps = new_scene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, (unsigned)scene->hittable_count);
    rtcSetGeometryUserData(geometry, scene);
    rtcSetGeometryBoundsFunction(geometry, bound_lamp, NULL);
    rtcSetGeometryIntersectFunction(geometry, intersect_lamp);
    rtcSetGeometryOccludedFunction(geometry, occluded_lamp);
    attach(scene->accel->lamps, geometry, UINT32_MAX, 0);
    rtcCommitScene(scene->accel->lamps);
    return device_is_well(device, err);
}

void accel_lamps(const struct scene *scene, struct lamp_hits *hits)
{
    struct lamp_query query = {.hits = hits};
    rtcInitIntersectContext(&query.context);
    const struct ray *ray = hits->ray;
    struct RTCRayHit rayhit = {.ray =
                                   embree_ray(ray->origin, ray->direction, ray->near, ray->far, UINT32_MAX)};
    rayhit.hit.geomID = rayhit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(scene->accel->lamps, &query.context, &rayhit);
}
