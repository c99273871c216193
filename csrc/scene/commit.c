/* scene_commit: compiles materials, resolves names, builds acceleration structures and the table of lights.
   Each step runs only if what it depends on has changed since the last commit. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

/* --- Context ----------------------------------------------------------------------------------------- */

static bool same_context(const struct material_context *a, const struct scene_setup *b)
{
    return a->range.min == b->range.min && a->range.max == b->range.max && a->uv_rule == b->uv_rule &&
           memcmp(a->working_space.rgb_to_xyz, b->working_space.rgb_to_xyz,
                  sizeof a->working_space.rgb_to_xyz) == 0;
}

/* Spectra are tabulated over Λ when they come in, so what is compiled cannot follow a change of it. */
static bool set_context(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    if (!(setup->range.min > 0 && setup->range.max > setup->range.min))
        return fail(err, "settings", "lambda_min", "[%g, %g] nm is empty", (double)setup->range.min,
                    (double)setup->range.max);
    if (scene->default_material && same_context(&scene->context, setup))
        return true;
    for (size_t i = 0; i < scene->materials.count; i++)
        if (((const struct material_slot *)scene->materials.entry[i].item)->compiled)
            return fail(err, "settings", "lambda_min",
                        "wavelength range, UV rule or working space changed after materials were sent: send "
                        "them again");
    rgb_table_destroy(scene->rgb_table);
    spectrum_destroy(scene->illuminant);
    material_destroy(scene->default_material);
    scene->rgb_table = NULL;
    scene->illuminant = NULL;
    scene->default_material = NULL;
    scene->materials_dirty = scene->images_dirty = scene->lights_dirty = true;
    scene->context = (struct material_context){
        .range = setup->range, .uv_rule = setup->uv_rule, .working_space = setup->working_space};
    for (int i = 0; i < 3; i++) /* Y of the primaries */
        scene->context.luminance[i] = (float)setup->working_space.rgb_to_xyz[3 + i];
    return true;
}

static bool needs_table(const struct scene *scene)
{
    if (scene->world && scene->world->image_name)
        return true;
    for (size_t i = 0; i < scene->lamps.count; i++)
        if (((const struct lamp *)scene->lamps.entry[i].item)->input.emission->texture)
            return true;
    for (size_t i = 0; i < scene->materials.count; i++)
        if (((const struct material_slot *)scene->materials.entry[i].item)->needs_table)
            return true;
    return false;
}

static bool make_table(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    if (scene->rgb_table || !needs_table(scene))
        return true;
    scene->rgb_table = rgb_table_create(&setup->working_space, setup->threads);
    scene->illuminant = emission_white(scene);
    scene->context.rgb_table = scene->rgb_table;
    return (scene->rgb_table && scene->illuminant) ||
           fail(err, "settings", "working_space", "no table of its colours' spectra could be made");
}

/* --- Materials --------------------------------------------------------------------------------------- */

/* What "" names, and slots without a material: Cycles' grey. */
static bool make_default(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    if (scene->default_material)
        return true;
    struct closure *closure = calloc(1, sizeof *closure);
    struct color_node *color = calloc(1, sizeof *color);
    struct spectrum *grey = spectrum_constant(scene->context.range, 0.8f);
    if (!closure || !color || !grey) {
        free(closure);
        free(color);
        spectrum_destroy(grey);
        return fail(err, "default material", "reflectance", "no memory");
    }
    *color = (struct color_node){.spectrum = grey, .scale = 1};
    *closure = (struct closure){.kind = CLOSURE_BSDF, .bsdf = bsdf_kind_find("diffuse"), .color = {color}};
    scene->default_material =
        material_compile("default material", closure, &scene->context, setup->warn, setup->user, err);
    return scene->default_material;
}

/* A material that failed stays so until it is sent again; its error is told at each commit. */
static bool compile(struct scene *scene, const struct scene_setup *setup, struct material_slot *slot,
                    stokes_error *err)
{
    if (slot->closure) {
        struct closure *closure = slot->closure;
        slot->closure = NULL;
        slot->compiled =
            material_compile(slot->name, closure, &scene->context, setup->warn, setup->user, &slot->error);
        slot->failed = !slot->compiled;
    }
    if (slot->failed && err)
        *err = slot->error;
    return !slot->failed;
}

static bool number_fluorophores(struct scene *scene, stokes_error *err)
{
    int count = 0;
    for (size_t i = 0; i < scene->materials.count; i++)
        count += material_fluorophore_count(
            ((const struct material_slot *)scene->materials.entry[i].item)->compiled);
    struct material **material = malloc(((size_t)count + 1) * sizeof *material);
    int *first = malloc(((size_t)count + 1) * sizeof *first);
    if (!material || !first) {
        free(material);
        free(first);
        return fail(err, "scene", "materials", "no memory for %d fluorophores", count);
    }
    free(scene->fluorophore_material);
    free(scene->fluorophore_first);
    scene->fluorophore_material = material;
    scene->fluorophore_first = first;
    scene->fluorophore_count = 0;
    for (size_t i = 0; i < scene->materials.count; i++) {
        struct material *compiled = ((const struct material_slot *)scene->materials.entry[i].item)->compiled;
        int start = scene->fluorophore_count;
        material_set_fluorophores(compiled, start);
        for (int f = material_fluorophore_count(compiled); f > 0; f--) {
            material[scene->fluorophore_count] = compiled;
            first[scene->fluorophore_count++] = start;
        }
    }
    return true;
}

static bool compile_materials(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    if (!make_default(scene, setup, err))
        return false;
    registry_sort(&scene->materials);
    for (size_t i = 0; i < scene->materials.count; i++)
        if (!compile(scene, setup, scene->materials.entry[i].item, err))
            return false;
    return number_fluorophores(scene, err);
}

/* --- UV layers by name ------------------------------------------------------------------------------- */

/* Index of a layer's name, which is added if new; 0 is the default layer. −1: no memory. */
static int layer_index(struct scene *scene, const char *name)
{
    if (!*name)
        return 0;
    for (uint32_t i = 0; i < scene->uv_name_count; i++)
        if (strcmp(scene->uv_names[i], name) == 0)
            return (int)i + 1;
    char **names = realloc(scene->uv_names, (scene->uv_name_count + 1) * sizeof *names);
    if (names)
        scene->uv_names = names;
    char *copy = names ? copy_text(name) : NULL;
    if (!copy)
        return -1;
    names[scene->uv_name_count++] = copy;
    return (int)scene->uv_name_count;
}

static bool resolve_layers(struct scene *scene, stokes_error *err)
{
    bool good = true;
    for (size_t i = 0; i < scene->materials.count; i++) {
        const struct material *material =
            ((const struct material_slot *)scene->materials.entry[i].item)->compiled;
        for (size_t t = 0; good && t < material_texture_count(material); t++) {
            struct texture *texture = material_texture(material, t);
            texture->uv_layer = layer_index(scene, texture->uv_name);
            good = texture->uv_layer >= 0;
        }
    }
    for (size_t i = 0; good && i < scene->meshes.count; i++)
        good = mesh_resolve_uv(scene->meshes.entry[i].item, scene->uv_names, scene->uv_name_count);
    return good || fail(err, "scene", "uv", "no memory for %u layers", scene->uv_name_count);
}

/* --- Instances --------------------------------------------------------------------------------------- */

/* A slot's material; `mesh` gets the tangents that its normal maps need. */
static const struct material *find_material(const struct scene *scene, const struct instances *instances,
                                            size_t slot, struct mesh *mesh, stokes_error *err)
{
    const char *name = slot < instances->material_count ? instances->material_names[slot] : "";
    if (!*name)
        return scene->default_material;
    const struct material_slot *found = registry_find(&scene->materials, name);
    if (!found)
        fail(err, instances->name, "materials", "there is no material named \"%.200s\"", name);
    else if (found->has_normal_map && !mesh_build_tangents(mesh))
        fail(err, instances->mesh_name, "corner_normals", "no memory for tangents");
    else
        return found->compiled;
    return NULL;
}

static bool emits(const struct material *material)
{
    const struct spectrum *shape = material_emits(material) ? material_emission_shape(material) : NULL;
    return shape && spectrum_integral(shape) > 0;
}

static bool resolve_slots(struct scene *scene, struct instances *instances, stokes_error *err)
{
    size_t count = instances->material_count ? instances->material_count : 1;
    struct mesh *mesh = registry_find(&scene->meshes, instances->mesh_name);
    instances_forget(instances);
    instances->materials = calloc(count, sizeof *instances->materials);
    instances->emitter = calloc(count, sizeof *instances->emitter);
    instances->cdf = calloc(count, sizeof *instances->cdf);
    if (!instances->materials || !instances->emitter || !instances->cdf)
        return fail(err, instances->name, "materials", "no memory for %zu", count);
    instances->slot_count = count;
    for (size_t slot = 0; slot < count; slot++) {
        const struct material *material = find_material(scene, instances, slot, mesh, err);
        if (!(instances->materials[slot] = material))
            return false;
        instances->emitter[slot] = emits(material) ? (int)instances->emitter_count++ : -1;
        scene->transparent = scene->transparent || material_may_be_transparent(material);
    }
    return true;
}

static bool resolve_instances(struct scene *scene, stokes_error *err)
{
    scene->transparent = scene->mixed = false;
    for (size_t i = 0; i < scene->instances.count; i++) {
        struct instances *instances = scene->instances.entry[i].item;
        scene->mixed = scene->mixed || (instances->mask & SEEN_BY_SOME);
        if (!resolve_slots(scene, instances, err))
            return false;
        for (size_t slot = 0; slot < instances->slot_count; slot++)
            if (instances->emitter[slot] >= 0 &&
                !triangle_cdf_build(&instances->cdf[slot], instances, instances->mesh, NULL, slot))
                return fail(err, instances->name, "emission", "no memory for its table of triangles");
    }
    return true;
}

/* --- Bounds ------------------------------------------------------------------------------------------ */

struct box {
    struct vec3 low, high;
};

static void grow(struct box *box, struct vec3 p)
{
    box->low = vec3(fminf(box->low.x, p.x), fminf(box->low.y, p.y), fminf(box->low.z, p.z));
    box->high = vec3(fmaxf(box->high.x, p.x), fmaxf(box->high.y, p.y), fmaxf(box->high.z, p.z));
}

/* Beyond this (m), squares of distances leave the range of floats. */
#define RADIUS_MAX 1e15f

static bool measure(struct scene *scene, stokes_error *err)
{
    struct box box = {vec3(INFINITY, INFINITY, INFINITY), vec3(-INFINITY, -INFINITY, -INFINITY)};
    for (size_t i = 0; i < scene->object_count; i++) {
        const struct object *object = &scene->objects[i];
        struct vec3 low = object->mesh->low, high = object->mesh->high;
        for (int corner = 0; corner < 8; corner++)
            grow(&box, transform_point(&object->to_world,
                                       vec3(corner & 1 ? low.x : high.x, corner & 2 ? low.y : high.y,
                                            corner & 4 ? low.z : high.z)));
    }
    if (scene->camera)
        grow(&box, scene->camera->position);
    bool empty = !(box.low.x <= box.high.x);
    scene->center = empty ? vec3(0, 0, 0) : scale(add(box.low, box.high), 0.5f);
    float radius = empty ? 0 : 0.5f * length(sub(box.high, box.low));
    /* A margin for rounding, and for a scene that is a point. */
    scene->radius = 1.001f * radius + 1e-5f * length(scene->center) + (radius > 0 ? 0 : 1);
    return scene->radius <= RADIUS_MAX ||
           fail(err, "scene", "bounds", "objects and camera lie more than %g m apart", (double)RADIUS_MAX);
}

/* --- Images ------------------------------------------------------------------------------------------ */

static bool image_is_used(const struct scene *scene, const struct image *image)
{
    for (size_t i = 0; i < scene->materials.count; i++) {
        const struct material *material =
            ((const struct material_slot *)scene->materials.entry[i].item)->compiled;
        for (size_t t = 0; t < material_texture_count(material); t++)
            if (material_texture(material, t)->image == image)
                return true;
    }
    for (size_t i = 0; i < scene->lamps.count; i++) {
        const struct texture *texture =
            ((const struct lamp *)scene->lamps.entry[i].item)->input.emission->texture;
        if (texture && texture->image == image)
            return true;
    }
    return false;
}

static void free_unused_images(struct scene *scene)
{
    size_t kept = 0;
    for (size_t i = 0; i < scene->retired_count; i++)
        if (image_is_used(scene, scene->retired[i]))
            scene->retired[kept++] = scene->retired[i];
        else
            image_destroy(scene->retired[i]);
    scene->retired_count = kept;
}

/* --- All of it --------------------------------------------------------------------------------------- */

static bool commit_geometry(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    if (!scene->accel && !(scene->accel = accel_create(setup->threads, err)))
        return false;
    if (scene->geometry_dirty && !scene_build_objects(scene, err))
        return false;
    if ((scene->geometry_dirty || scene->materials_dirty) &&
        !(resolve_layers(scene, err) && resolve_instances(scene, err)))
        return false;
    if (scene->geometry_dirty && !accel_build(scene, setup, err))
        return false;
    for (size_t i = 0; i < scene->meshes.count; i++)
        ((struct mesh *)scene->meshes.entry[i].item)->hit.window =
            scene->camera ? &scene->camera->window : NULL;
    return true;
}

bool scene_commit(struct scene *scene, const struct scene_setup *setup, stokes_error *err)
{
    scene->committed = false;
    if (!set_context(scene, setup, err) || !make_table(scene, setup, err))
        return false;
    if (scene->materials_dirty && !compile_materials(scene, setup, err))
        return false;
    bool rebuild_lights = scene->geometry_dirty || scene->materials_dirty || scene->lights_dirty;
    if (!commit_geometry(scene, setup, err))
        return false;
    if ((scene->geometry_dirty || scene->camera_dirty) && !measure(scene, err))
        return false;
    if (rebuild_lights && !(scene_build_lights(scene, err) && accel_build_lamps(scene, err)))
        return false;
    if ((rebuild_lights || scene->camera_dirty) && !scene_weigh_lights(scene, err))
        return false;
    if (!scene_list_volumes(scene, err))
        return false;
    scene_place_camera(scene);
    free_unused_images(scene);
    scene->geometry_dirty = scene->materials_dirty = scene->images_dirty = false;
    scene->lights_dirty = scene->camera_dirty = false;
    scene->committed = true;
    return true;
}
