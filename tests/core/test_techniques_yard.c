/* A yard with some of everything: a sky of pixels, a sun, lamps of lines 1 nm wide with and without area, a thin lens, textures (of a dye's concentration, too),
   mixes, metal, glass too smooth for its runs to be evaluated again, and shading normals; by night, a bead that diffuse rays do not see. Techniques deliver what they promise there as well. */
#include "boxes.h"
#include "ledger.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdlib.h>

#include "session/session.h"
#include "stream_kit.h"

#include <cmocka.h>

static stokes_session *session; /* of the scene at hand, for what its messages made */

static void send_with(const char *name, const char *json, const void *blobs, size_t bytes)
{
    stokes_error err;
    if (!stream_send_with(session, name, json, blobs, bytes, &err))
        fail_msg("%s: %s, %s: %s", name, err.object, err.property, err.text);
}

static void send(const char *name, const char *json)
{
    send_with(name, json, NULL, 0);
}

static void send_images(void)
{
    float sky[8 * 4 * 3], spots[4 * 4];
    for (int i = 0; i < 8 * 4 * 3; i++)
        sky[i] = 0.05f + 0.1f * (float)(i * 7 % 11) / 11;
    for (int i = 0; i < 4 * 4; i++)
        spots[i] = (float)(i * 5 % 16) / 15;
    send_with("image",
              "{\"name\": \"sky\", \"width\": 8, \"height\": 4, \"channels\": 3, \"format\": \"f32\", "
              "\"colorspace\": \"\", "
              "\"pixels\": {\"at\": 0, \"bytes\": 384}}",
              sky, sizeof sky);
    send_with("image",
              "{\"name\": \"spots\", \"width\": 4, \"height\": 4, \"channels\": 1, \"format\": \"f32\", "
              "\"colorspace\": "
              "\"data\", \"pixels\": {\"at\": 0, \"bytes\": 64}}",
              spots, sizeof spots);
}

#define SPOTS "{\"texture\": {\"image\": \"spots\", \"projection\": \"object\", \"channel\": \"r\"}}"
#define DYE(concentration)                                                                                   \
    "{\"bsdf\": \"fluorescent\", \"reflectance\": 0.7, \"absorption\": {\"gaussian\": {\"mean\": 440, "      \
    "\"sigma\": 60, \"peak\": 0.9}}, \"emission\": {\"gaussian\": {\"mean\": 590, \"sigma\": 30}}, "         \
    "\"yield\": "                                                                                            \
    "0.8, \"yield_kind\": \"energy\", \"concentration\": " concentration "}"

static void send_materials(void)
{
    send("material", "{\"name\": \"floor\", \"surface\": " DYE(SPOTS) "}");
    send("material",
         "{\"name\": \"wall\", \"surface\": {\"mix\": [{\"bsdf\": \"diffuse\", \"reflectance\": {\"table\": "
         "{\"lambda\": [300, 500, 650, 830], \"value\": [0.2, 0.3, 0.7, 0.6]}}}, {\"bsdf\": \"conductor\", "
         "\"metal\": \"Au\", \"roughness\": 0.4}], \"factor\": " SPOTS "}}");
    send("material", "{\"name\": \"bead\", \"surface\": {\"mix\": [" DYE(
                         "0.8") ", {\"bsdf\": \"glossy\", "
                                "\"color\": 0.7, \"roughness\": 0.5}], \"factor\": 0.4}}");
    send("material", "{\"name\": \"glass\", \"surface\": {\"bsdf\": \"dielectric\", \"ior\": {\"n_d\": 1.5, "
                     "\"abbe\": 20}, \"roughness\": 0.15}}");
}

#define LINE(center, width) "{\"line\": {\"center\": " center ", \"width\": " width "}}"
#define MERCURY(width)                                                                                       \
    "{\"shape\": {\"sum\": [" LINE("404.7", width) ", " LINE("546.1",                                        \
                                                             width) "]}, \"scale\": 4, \"unit\": \"total\"}"
#define SODIUM(width) "{\"shape\": " LINE("589.3", width) ", \"scale\": 3, \"unit\": \"total\"}"
#define BULB(width)                                                                                          \
    "{\"name\": \"bulb\", \"kind\": \"point\", \"transform\": [1,0,0,-0.5, 0,1,0,-0.4, 0,0,1,0.9], "         \
    "\"emission\": " MERCURY(width) "}"
#define PANEL(width)                                                                                         \
    "{\"name\": \"panel\", \"kind\": \"rectangle\", \"transform\": [1,0,0,0.4, 0,1,0,0.2, 0,0,1,0.9], "      \
    "\"size\": [0.6, 0.6], \"emission\": " SODIUM(width) "}"

enum hour { DAY, HAZY_DAY, NIGHT };

static void send_lights(enum hour hour)
{
    bool broad = hour == HAZY_DAY;
    send("light", broad ? BULB("60") : BULB("1"));
    if (hour == NIGHT)
        return;
    send("light", broad ? PANEL("60") : PANEL("1"));
    send("world", "{\"kind\": \"image\", \"image\": \"sky\", \"scale\": 1}");
    send("light",
         "{\"name\": \"sun\", \"kind\": \"sun\", \"transform\": [1,0,0,0, 0,0.8,0.6,0, 0,-0.6,0.8,0], "
         "\"angle\": 0.3, \"emission\": {\"shape\": {\"illuminant\": \"D65\"}, \"scale\": 1, \"unit\": "
         "\"total\"}}");
}

/* An object of boxes.h, again. */
static void hide_from_diffuse_rays(const char *name)
{
    static const float identity[12] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0};
    struct instances_input instances = {.name = name,
                                        .mesh = name,
                                        .materials = &name,
                                        .material_count = 1,
                                        .transforms = identity,
                                        .transform_count = 1,
                                        .visible = {true, false, true, true, true, true}};
    stokes_error err;
    assert_true(scene_add_instances(session->scene, &instances, &err));
}

static struct scene *build(struct range range, int pixels, enum hour hour)
{
    static const float floor[4][3] = {{-1.5f, -1.5f, -0.7f},
                                      {1.5f, -1.5f, -0.7f},
                                      {1.5f, 1.5f, -0.7f},
                                      {-1.5f, 1.5f, -0.7f}},
                       wall[4][3] = {{-1.5f, 1, -0.7f}, {1.5f, 1, -0.7f}, {1.5f, 1, 0.8f}, {-1.5f, 1, 0.8f}};
    char camera[400];
    stokes_error err;
    session = stream_greeted();
    send_images();
    send_materials();
    send_lights(hour);
    box_add_quad(session->scene, "floor", "floor", floor);
    box_add_quad(session->scene, "wall", "wall", wall);
    box_add_sphere(session->scene, "bead", "bead", (float[3]){-0.4f, 0.2f, -0.4f}, 0.3f);
    if (hour == NIGHT)
        hide_from_diffuse_rays("bead");
    box_add_sphere(session->scene, "glass", "glass", (float[3]){0.4f, 0, -0.4f}, 0.3f);
    snprintf(
        camera, sizeof camera,
        "{\"kind\": \"perspective\", \"transform\": [1,0,0,0, 0,0,-1,-1.8, 0,1,0,0], \"frame\": [-0.6, 0.6, "
        "-0.6, 0.6], \"resolution\": [%d, %d], \"clip\": [0.01, 100], \"lens_radius\": 0.05, "
        "\"focus_distance\": 2}",
        pixels, pixels);
    send("camera", camera);
    assert_true(session->settings.integrator.lambda_min == range.min &&
                session->settings.integrator.lambda_max == range.max);
    if (!session_commit(session, &session->settings, &err))
        fail_msg("%s, %s: %s", err.object, err.property, err.text);
    return session->scene;
}

static struct scene *yard_scene(struct range range, int pixels)
{
    return build(range, pixels, DAY);
}

/* With lines of 60 nm: beside those of 1 nm a kernel is wide, and half of what it joins may be missing (algorithm.md §6). */
static struct scene *hazy_scene(struct range range, int pixels)
{
    return build(range, pixels, HAZY_DAY);
}

/* With the bulb alone, which no ray hits: what rays do not see, shadow rays might. */
static struct scene *night_scene(struct range range, int pixels)
{
    return build(range, pixels, NIGHT);
}

/* The scene is gone by then. */
static int end_session(void **state)
{
    (void)state;
    session->scene = NULL;
    stokes_session_destroy(session);
    return 0;
}

int main(void)
{
    static struct subject yard_bdpt = {
        .name = "bdpt", .lanes = 1, .edges = 3, .samples = 32, .place = yard_scene, .sees_error = 0.08};
    static struct subject yard_bdpt_4 = {
        .name = "bdpt", .lanes = 4, .edges = 3, .samples = 20, .place = yard_scene, .sees_error = 0.08};
    static struct subject hazy_mbdpt = {.name = "mbdpt",
                                        .lanes = 1,
                                        .edges = 3,
                                        .samples = 64,
                                        .place = hazy_scene,
                                        .sees_error = 0.05,
                                        .half_width_nm = 16};
    static struct subject night_bdpt_4 = {
        .name = "bdpt", .lanes = 4, .edges = 4, .samples = 24, .place = night_scene, .sees_error = 0.1};
#define YARD(subject)                                                                                        \
    {                                                                                                        \
#subject, techniques_deliver_what_they_claim, NULL, end_session, &subject                            \
    }
    const struct CMUnitTest tests[] = {YARD(yard_bdpt), YARD(yard_bdpt_4), YARD(hazy_mbdpt),
                                       YARD(night_bdpt_4)};
    if (getenv("STOKES_TEST_ONLY"))
        cmocka_set_test_filter(getenv("STOKES_TEST_ONLY"));
    return cmocka_run_group_tests(tests, NULL, NULL);
}
