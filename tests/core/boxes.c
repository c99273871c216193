/* Builds the boxes; any failure fails the running test with the error's text. */
#include "boxes.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include <string.h>

#include "film/film.h"

/* cmocka's `fail` macro hides base/error.h's function: included last. */
#include <cmocka.h>

static void expect(bool ok, const stokes_error *err)
{
    if (!ok)
        fail_msg("%s: %s: %s", err->object, err->property, err->text);
}

static struct color_node *flat(struct range range, float value)
{
    struct color_node *node = calloc(1, sizeof *node);
    node->spectrum = spectrum_constant(range, value);
    node->scale = 1;
    return node;
}

static struct color_node *bell(struct range range, double mean, double sigma, double peak)
{
    struct color_node *node = calloc(1, sizeof *node);
    node->spectrum = spectrum_gaussian(range, mean, sigma, peak, "bell", NULL);
    node->scale = 1;
    return node;
}

static struct closure *bsdf(const char *name)
{
    struct closure *c = calloc(1, sizeof *c);
    c->kind = CLOSURE_BSDF;
    c->bsdf = bsdf_kind_find(name);
    assert_non_null(c->bsdf);
    memcpy(c->number, bsdf_kind_signature(c->bsdf)->number_defaults, sizeof c->number);
    return c;
}

/* The place of an input among the kind's names. */
static int place(const struct closure *c, const char *name)
{
    const struct bsdf_signature *signature = bsdf_kind_signature(c->bsdf);
    for (int i = 0; i < CLOSURE_COLORS && signature->color_names[i]; i++)
        if (strcmp(signature->color_names[i], name) == 0)
            return i;
    for (int i = 0; i < CLOSURE_VALUES && signature->value_names[i]; i++)
        if (strcmp(signature->value_names[i], name) == 0)
            return i;
    for (int i = 0; i < 4 && signature->number_names[i]; i++)
        if (strcmp(signature->number_names[i], name) == 0)
            return i;
    for (int i = 0; i < 4 && signature->option_names[i]; i++)
        if (strcmp(signature->option_names[i], name) == 0)
            return i;
    fail_msg("no input '%s'", name);
    return -1;
}

struct closure *box_diffuse(struct range range, float reflectance)
{
    struct closure *c = bsdf("diffuse");
    c->color[place(c, "reflectance")] = flat(range, reflectance);
    return c;
}

static void set_value(struct closure *c, const char *name, float constant)
{
    struct value_node *value = calloc(1, sizeof *value);
    value->constant = constant;
    c->value[place(c, name)] = value;
}

struct closure *box_fluorescent(struct range range, float concentration, float energy_yield)
{
    struct closure *c = bsdf("fluorescent");
    c->color[place(c, "reflectance")] = flat(range, 0.7f);
    c->color[place(c, "absorption")] = bell(range, 450, 60, 0.9);
    c->color[place(c, "emission")] = bell(range, 590, 30, 1);
    set_value(c, "concentration", concentration);
    c->number[place(c, "yield")] = energy_yield;
    const struct bsdf_signature *signature = bsdf_kind_signature(c->bsdf);
    int kind = place(c, "yield_kind");
    while (strcmp(signature->option_choices[kind][c->option[kind]], "energy") != 0)
        c->option[kind]++;
    return c;
}

struct closure *box_glass(double n_d, double abbe)
{
    struct closure *c = bsdf("dielectric");
    c->ior = (struct ior){IOR_ABBE, {n_d, abbe}};
    return c;
}

struct closure *box_lamp(struct range range, float radiance_per_nm)
{
    struct closure *c = calloc(1, sizeof *c);
    c->kind = CLOSURE_EMISSION;
    c->emission = calloc(1, sizeof *c->emission);
    c->emission->spectrum = spectrum_constant(range, radiance_per_nm);
    c->emission->scale = 1;
    return c;
}

static void add_instance_seen(struct scene *scene, const char *mesh, const char *material,
                              struct visibility visible)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    stokes_error err;
    struct instances_input instances = {.name = mesh,
                                        .mesh = mesh,
                                        .materials = &material,
                                        .material_count = 1,
                                        .transforms = identity,
                                        .transform_count = 1,
                                        .visible = visible};
    expect(scene_add_instances(scene, &instances, &err), &err);
}

static void add_instance(struct scene *scene, const char *mesh, const char *material)
{
    add_instance_seen(scene, mesh, material, (struct visibility){true, true, true, true, true, true});
}

void box_add_quad(struct scene *scene, const char *name, const char *material, const float corners[4][3])
{
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    stokes_error err;
    struct mesh_input mesh = {.name = name,
                              .positions = corners[0],
                              .vertex_count = 4,
                              .triangles = triangles,
                              .triangle_count = 2};
    expect(scene_add_mesh(scene, &mesh, &err), &err);
    add_instance(scene, name, material);
}

void box_add_sphere(struct scene *scene, const char *name, const char *material, const float center[3],
                    float radius)
{
    enum { AROUND = 48, DOWN = 24, VERTICES = (DOWN + 1) * AROUND };
    static float positions[VERTICES][3];
    static uint32_t triangles[2 * AROUND * DOWN][3], corners[2 * AROUND * DOWN][3];
    static float normals[VERTICES][3];
    size_t count = 0;
    for (int i = 0; i <= DOWN; i++)
        for (int j = 0; j < AROUND; j++) {
            float theta = PI_F * (float)i / DOWN, phi = 2 * PI_F * (float)j / AROUND;
            float n[3] = {sinf(theta) * cosf(phi), sinf(theta) * sinf(phi), cosf(theta)};
            for (int k = 0; k < 3; k++) {
                normals[i * AROUND + j][k] = n[k];
                positions[i * AROUND + j][k] = center[k] + radius * n[k];
            }
        }
    for (uint32_t i = 0; i < DOWN; i++)
        for (uint32_t j = 0; j < AROUND; j++) {
            uint32_t a = i * AROUND + j, b = i * AROUND + (j + 1) % AROUND, c = a + AROUND, d = b + AROUND;
            if (i > 0)
                memcpy(triangles[count++], (uint32_t[3]){a, c, b}, sizeof *triangles);
            if (i < DOWN - 1)
                memcpy(triangles[count++], (uint32_t[3]){b, c, d}, sizeof *triangles);
        }
    memcpy(corners, triangles, sizeof corners);
    stokes_error err;
    struct mesh_input mesh = {.name = name,
                              .positions = positions[0],
                              .vertex_count = VERTICES,
                              .triangles = triangles[0],
                              .triangle_count = count,
                              .corners = corners[0],
                              .corner_normals = normals[0],
                              .corner_count = VERTICES};
    expect(scene_add_mesh(scene, &mesh, &err), &err);
    add_instance(scene, name, material);
}

static void add_walls(struct scene *scene)
{
    static const struct {
        const char *name, *material;
        float corners[4][3];
    } walls[] = {
        {"floor", "dye", {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}}},
        {"ceiling", "grey", {{-1, -1, 1}, {-1, 1, 1}, {1, 1, 1}, {1, -1, 1}}},
        {"left", "grey", {{-1, -1, -1}, {-1, 1, -1}, {-1, 1, 1}, {-1, -1, 1}}},
        {"right", "dye", {{1, -1, -1}, {1, -1, 1}, {1, 1, 1}, {1, 1, -1}}},
        {"back", "grey", {{-1, 1, -1}, {1, 1, -1}, {1, 1, 1}, {-1, 1, 1}}},
        {"front", "grey", {{-1, -1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, -1, -1}}},
    };
    for (size_t i = 0; i < sizeof walls / sizeof *walls; i++)
        box_add_quad(scene, walls[i].name, walls[i].material, walls[i].corners);
}

static void add_camera(struct scene *scene, int pixels)
{
    /* Looks along +y: columns of the rotation are the camera's x, y, z axes in the world. */
    struct camera_input camera = {.transform = {{1, 0, 0, 0, 0, 0, -1, -0.9f, 0, 1, 0, 0}},
                                  .frame = {-0.9f, 0.9f, -0.9f, 0.9f},
                                  .resolution = {pixels, pixels},
                                  .border = {0, 0, pixels, pixels},
                                  .clip = {0.01f, 100},
                                  .aspect = 1};
    stokes_error err;
    expect(scene_set_camera(scene, &camera, &err), &err);
}

static void commit(struct scene *scene, struct range range)
{
    struct scene_setup setup = {.range = range, .uv_rule = UV_HOLD, .threads = 1};
    stokes_error err;
    working_space_rec709(&setup.working_space);
    expect(scene_commit(scene, &setup, &err), &err);
}

struct scene *hidden_lamp_scene(struct range range, int pixels)
{
    static const float floor[4][3] = {{-1, -1, -0.5f}, {1, -1, -0.5f}, {1, 1, -0.5f}, {-1, 1, -0.5f}};
    static const float seen[4][3] = {
        {-0.6f, 0, 0.3f}, {-0.6f, 0.4f, 0.3f}, {-0.2f, 0.4f, 0.3f}, {-0.2f, 0, 0.3f}};
    static const float hidden[4][3] = {
        {0.2f, 0, 0.2f}, {0.2f, 0.4f, 0.3f}, {0.6f, 0.4f, 0.3f}, {0.6f, 0, 0.2f}};
    struct scene *scene = scene_create();
    stokes_error err;
    expect(scene_add_material(scene, "grey", box_diffuse(range, 0.6f), &err), &err);
    expect(scene_add_material(scene, "lamp", box_lamp(range, 0.1f), &err), &err);
    box_add_quad(scene, "floor", "grey", floor);
    box_add_quad(scene, "seen", "lamp", seen);
    box_add_quad(scene, "hidden", "lamp", hidden);
    add_instance_seen(scene, "hidden", "lamp", (struct visibility){.camera = true});
    add_camera(scene, pixels);
    commit(scene, range);
    return scene;
}

static void add_world(struct scene *scene, struct range range, float radiance_per_nm)
{
    struct world_input world = {.scale = 1, .visible = {true, true, true, true, true, true}};
    stokes_error err;
    world.emission = calloc(1, sizeof *world.emission);
    world.emission->spectrum = spectrum_constant(range, radiance_per_nm);
    world.emission->scale = 1;
    expect(scene_set_world(scene, &world, &err), &err);
}

struct scene *world_scene(struct range range, float radiance_per_nm, int pixels)
{
    struct scene *scene = scene_create();
    add_world(scene, range, radiance_per_nm);
    add_camera(scene, pixels);
    commit(scene, range);
    return scene;
}

struct scene *hole_scene(struct range range, int pixels)
{
    static const float left[4][3] = {{-5, 2, -5}, {-5, 2, 5}, {0, 2, 5}, {0, 2, -5}};
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    static const uint32_t triangles[6] = {0, 1, 2, 0, 2, 3};
    const char *material = "grey";
    struct scene *scene = scene_create();
    struct mesh_input mesh = {
        .name = "hole", .positions = left[0], .vertex_count = 4, .triangles = triangles, .triangle_count = 2};
    struct instances_input instances = {.name = "hole",
                                        .mesh = "hole",
                                        .materials = &material,
                                        .material_count = 1,
                                        .transforms = identity,
                                        .transform_count = 1,
                                        .visible = {true, true, true, true, true, true},
                                        .holdout = true};
    stokes_error err;
    expect(scene_add_material(scene, "grey", box_diffuse(range, 0.6f), &err), &err);
    expect(scene_add_mesh(scene, &mesh, &err), &err);
    expect(scene_add_instances(scene, &instances, &err), &err);
    add_world(scene, range, 0.01f);
    add_camera(scene, pixels);
    commit(scene, range);
    return scene;
}

/* Coefficients that rise (or fall) with the wavelength, per metre. */
static struct volume *volume(struct range range, float scattering_blue, float scattering_red,
                             float absorption_blue, float absorption_red, float g)
{
    const float lambda[2] = {range.min, range.max};
    struct volume *v =
        volume_create(spectrum_table(range, lambda, (float[2]){scattering_blue, scattering_red}, 2,
                                     BEYOND_HOLD, "σs", NULL),
                      spectrum_table(range, lambda, (float[2]){absorption_blue, absorption_red}, 2,
                                     BEYOND_HOLD, "σa", NULL),
                      g);
    assert_true(v && volume_finish(v));
    return v;
}

static struct closure *clear(void)
{
    return bsdf("transparent");
}

/* What fills a box of box_of. */
enum filling { FILLED_NOT, FILLED_WITH_MIST, FILLED_GLASS, FROSTED };

static void add_mist(struct scene *scene, struct range range)
{
    static const float around[3] = {0.3f, 0.2f, -0.3f};
    struct world_input world = {.scale = 1, .volume = volume(range, 0.9f, 0.2f, 0.02f, 0.3f, 0.3f)};
    stokes_error err;
    world.emission = calloc(1, sizeof *world.emission);
    world.emission->spectrum = spectrum_constant(range, 0);
    world.emission->scale = 1;
    expect(scene_set_world(scene, &world, &err), &err);
    expect(scene_add_material_with(scene, "cloud", clear(), volume(range, 0.5f, 2.5f, 0.3f, 0, -0.4f), &err),
           &err);
    box_add_sphere(scene, "cloud", "cloud", around, 0.5f);
}

static struct scene *filled_box_of(struct range range, struct closure *floor, bool lenses, bool ball,
                                   enum filling filling, int pixels)
{
    static const float lamp[4][3] = {
        {-0.15f, -0.15f, 0.5f}, {-0.15f, 0.15f, 0.5f}, {0.15f, 0.15f, 0.5f}, {0.15f, -0.15f, 0.5f}};
    struct scene *scene = scene_create();
    stokes_error err;
    expect(scene_add_material(scene, "grey", box_diffuse(range, 0.6f), &err), &err);
    expect(scene_add_material(scene, "dye", floor, &err), &err);
    struct volume *inside = filling == FILLED_GLASS ? volume(range, 3, 1, 0.1f, 1, 0.2f) : NULL;
    struct closure *glass = box_glass(1.5, 20);
    if (filling == FROSTED)
        set_value(glass, "roughness", 0.4f);
    expect(scene_add_material_with(scene, "glass", glass, inside, &err), &err);
    expect(scene_add_material(scene, "lamp", box_lamp(range, 0.1f), &err), &err);
    add_walls(scene);
    add_camera(scene, pixels);
    box_add_quad(scene, "lamp", "lamp", lamp);
    if (ball)
        box_add_sphere(scene, "ball", "glass",
                       lenses ? (float[3]){0, 0, 0.5f} : (float[3]){0.3f, 0.3f, -0.5f},
                       lenses ? 0.35f : 0.4f);
    if (lenses)
        box_add_sphere(scene, "lens", "glass", (float[3]){0, -0.45f, 0}, 0.3f);
    if (filling == FILLED_WITH_MIST)
        add_mist(scene, range);
    commit(scene, range);
    return scene;
}

static struct scene *box_of(struct range range, struct closure *floor, bool lenses, bool ball, int pixels)
{
    return filled_box_of(range, floor, lenses, ball, FILLED_NOT, pixels);
}

struct scene *misty_box_scene(struct range range, int pixels)
{
    return filled_box_of(range, box_fluorescent(range, 0.8f, 0.8f), false, false, FILLED_WITH_MIST, pixels);
}

struct scene *bottle_box_scene(struct range range, int pixels)
{
    return filled_box_of(range, box_fluorescent(range, 0.8f, 0.8f), true, true, FILLED_GLASS, pixels);
}

struct scene *frosted_box_scene(struct range range, int pixels)
{
    return filled_box_of(range, box_fluorescent(range, 0.8f, 0.8f), false, true, FROSTED, pixels);
}

struct scene *box_scene(struct range range, bool lenses, int pixels)
{
    return box_of(range, box_fluorescent(range, 0.8f, 0.8f), lenses, true, pixels);
}

struct scene *grey_box_scene(struct range range, int pixels)
{
    return box_of(range, box_diffuse(range, 0.6f), false, false, pixels);
}

/* Takes the spectra. */
static struct closure *dye_of(struct range range, float concentration, struct spectrum *absorption,
                              struct spectrum *emission)
{
    struct closure *dye = box_fluorescent(range, concentration, 0.9f);
    struct color_node *taken = dye->color[place(dye, "absorption")],
                      *given = dye->color[place(dye, "emission")];
    spectrum_destroy(taken->spectrum);
    taken->spectrum = absorption;
    spectrum_destroy(given->spectrum);
    given->spectrum = emission;
    return dye;
}

struct scene *saturated_box_scene(struct range range, int pixels)
{
    return box_of(range,
                  dye_of(range, 1, spectrum_line(range, 450, 120, "band", NULL),
                         spectrum_gaussian(range, 530, 30, 1, "bell", NULL)),
                  false, false, pixels);
}

struct scene *banded_box_scene(struct range range, int pixels)
{
    return box_of(range,
                  dye_of(range, 0.8f, spectrum_line(range, 450, 160, "band", NULL),
                         spectrum_line(range, 560, 180, "band", NULL)),
                  false, true, pixels);
}

/* --- Renders ------------------------------------------------------------------------------------------------ */

struct integrator_settings box_settings(const char *name, double d_nm)
{
    struct integrator_settings settings = integrator_settings_default();
    settings.name = name;
    settings.d0_nm = d_nm;
    settings.shrink = 0;
    return settings;
}

/* Mean Y of the lower part of the picture, where no lamp is, in batches, one a seed. */
struct batches box_mean_below(const struct scene *scene, struct range range,
                              struct integrator_settings settings, int samples)
{
    enum { PIXELS = 16 };
    int border[4] = {0, 0, PIXELS, PIXELS};
    struct film *film = film_create(PIXELS, PIXELS, border, 0, range, NULL);
    struct batches batches = {0};
    for (settings.seed = 0; settings.seed < 32; settings.seed++) {
        struct integrator *it = integrator_create(&settings, scene, film, 1, NULL, NULL, NULL);
        double sum = 0;
        assert_non_null(it);
        film_clear(film);
        for (int sample = 0; sample < samples; sample++)
            for (int pixel = 0; pixel < PIXELS * PIXELS; pixel++)
                integrator_sample(it, 0, pixel % PIXELS, pixel / PIXELS, sample);
        for (int pixel = 0; pixel < PIXELS * PIXELS * 3 / 8; pixel++)
            sum += (double)film->sum[4 * pixel + 1] / (1 << FILM_FRACTION_BITS);
        batches_add(&batches, sum / samples);
        integrator_destroy(it);
    }
    film_destroy(film);
    return batches;
}
