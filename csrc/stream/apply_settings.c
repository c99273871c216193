/* `settings` and `color`: what everything after them is read with. */
#include <float.h>
#include <limits.h>
#include <string.h>

#include "base/error.h"
#include "stream/messages.h"

#define AT(member) offsetof(struct session_settings, member)

static const struct field settings_fields[] = {
    {"seed", FIELD_U32, false, AT(integrator.seed), 0, 0, UINT32_MAX},
    {"lanes", FIELD_INT, false, AT(integrator.lanes), 0, 0, INT_MAX},
    {"d0", FIELD_DOUBLE, false, AT(integrator.d0_nm), 0, 0, 1e6},
    {"shrink", FIELD_DOUBLE, false, AT(integrator.shrink), 0, 0, 1},
    {"light_paths", FIELD_DOUBLE, false, AT(integrator.light_paths), 0, 0, LIGHT_PATHS_MAX},
    {"max_path", FIELD_INT, false, AT(integrator.max_path), 0, 0, INT_MAX},
    {"max_camera", FIELD_INT, false, AT(integrator.max_camera), 0, 0, INT_MAX},
    {"max_light", FIELD_INT, false, AT(integrator.max_light), 0, 0, INT_MAX},
    {"max_diffuse", FIELD_INT, false, AT(integrator.max_diffuse), 0, 0, INT_MAX},
    {"max_glossy", FIELD_INT, false, AT(integrator.max_glossy), 0, 0, INT_MAX},
    {"max_transmission", FIELD_INT, false, AT(integrator.max_transmission), 0, 0, INT_MAX},
    {"max_volume", FIELD_INT, false, AT(integrator.max_volume), 0, 0, INT_MAX},
    {"max_transparent", FIELD_INT, false, AT(integrator.max_transparent), 0, 0, INT_MAX},
    {"roulette_start", FIELD_INT, false, AT(integrator.roulette_start), 0, 0, INT_MAX},
    {"lambda_min", FIELD_FLOAT, false, AT(integrator.lambda_min), 0, 0, 1e6},
    {"lambda_max", FIELD_FLOAT, false, AT(integrator.lambda_max), 0, 0, 1e6},
    {"filter_width", FIELD_FLOAT, false, AT(integrator.filter_width), 0, 0, 1e6},
    {"film_transparent", FIELD_BOOL, false, AT(integrator.film_transparent), 0, 0, 0},
    {"shared_wavelength", FIELD_BOOL, false, AT(integrator.shared_wavelength), 0, 0, 0},
    {"connectable_only", FIELD_BOOL, false, AT(integrator.connectable_only), 0, 0, 0},
    {"threads", FIELD_INT, false, AT(threads), 0, 0, INT_MAX},
    {"time_limit", FIELD_DOUBLE, false, AT(time_limit_s), 0, 0, DBL_MAX},
};

static bool read_techniques(const struct place *root, struct integrator_settings *s)
{
    struct place list = place_member(root, "techniques");
    if (!list.value)
        return true;
    if (!place_is(&list, JSON_ARRAY))
        return false;
    size_t count = json_array_size(list.value);
    memset(s->technique, 0, sizeof s->technique);
    s->all_techniques = count == 0;
    for (size_t i = 0; i < count; i++) {
        struct place element = place_element(&list, i);
        int st[2];
        if (!place_is(&element, JSON_ARRAY))
            return false;
        if (json_array_size(element.value) != 2)
            return place_fail(&element, "is no pair [s, t]");
        for (size_t k = 0; k < 2; k++) {
            struct place number = place_element(&element, k);
            double value;
            if (!read_whole(&number, 0, TECHNIQUES_MAX - 1, &value))
                return false;
            st[k] = (int)value;
        }
        s->technique[st[0]][st[1]] = true;
    }
    return true;
}

static bool read_bins(const struct place *root, struct integrator_settings *s)
{
    static const struct field fields[] = {
        {"count", FIELD_INT, true, offsetof(struct integrator_settings, spectral_bins), 0, 0, INT_MAX},
        {"min", FIELD_FLOAT, true, offsetof(struct integrator_settings, bins_min), 0, 0, 1e6},
        {"max", FIELD_FLOAT, true, offsetof(struct integrator_settings, bins_max), 0, 0, 1e6},
    };
    struct place bins = place_member(root, "spectral_bins");
    if (!bins.value)
        return true;
    if (json_is_null(bins.value)) {
        s->spectral_bins = 0;
        return true;
    }
    return place_is(&bins, JSON_OBJECT) && read_fields(&bins, fields, 3, s);
}

static bool read_choices(const struct place *root, struct session_settings *settings)
{
    static const char *const sides[] = {"light", "camera", NULL};
    static const char *const uv_rules[] = {"hold", "extrapolate", "zero", NULL};
    struct integrator_settings *s = &settings->integrator;
    struct place name = place_member(root, "integrator"), kernel = place_member(root, "kernel");
    struct place side = place_member(root, "mollify_side"), uv_rule = place_member(root, "uv_rule");
    const char *integrator, *kernels[KERNEL_COUNT + 1] = {NULL};
    for (int i = 0; i < KERNEL_COUNT; i++)
        kernels[i] = kernel_name((enum kernel)i);
    int chosen_kernel = (int)s->kernel, chosen_side = (int)s->mollify_side,
        chosen_rule = (int)settings->uv_rule;
    if (name.value) {
        if (!read_text(&name, &integrator))
            return false;
        s->name = session_integrator_name(integrator);
        if (!s->name)
            return place_fail(&name, "'%.64s' is unknown", integrator);
    }
    if ((kernel.value && !read_choice(&kernel, kernels, &chosen_kernel)) ||
        (side.value && !read_choice(&side, sides, &chosen_side)) ||
        (uv_rule.value && !read_choice(&uv_rule, uv_rules, &chosen_rule)))
        return false;
    s->kernel = (enum kernel)chosen_kernel;
    s->mollify_side = (enum side)chosen_side;
    settings->uv_rule = (enum uv_rule)chosen_rule;
    return true;
}

/* Spectra are made as they come, over Λ and in the working space of that moment. */
static bool check_order(const struct place *root, bool changes, const char *what)
{
    if (!changes || !root->message->session->uses_colors)
        return true;
    return place_fail(root, "%s cannot change any more: send it before everything that has a colour", what);
}

bool apply_settings(const struct place *root)
{
    stokes_session *session = root->message->session;
    struct session_settings settings = session->settings;
    const struct integrator_settings *old = &session->settings.integrator, *new = &settings.integrator;
    if (!read_fields(root, settings_fields, sizeof settings_fields / sizeof *settings_fields, &settings) ||
        !read_choices(root, &settings) || !read_techniques(root, &settings.integrator) ||
        !read_bins(root, &settings.integrator) || !session_settings_check(&settings, root->message->err))
        return false;
    bool range_changes = old->lambda_min != new->lambda_min || old->lambda_max != new->lambda_max;
    if (!check_order(root, range_changes, "the transport range") ||
        !check_order(root, settings.uv_rule != session->settings.uv_rule, "uv_rule"))
        return false;
    if (range_changes) {
        spectrum_destroy(session->white);
        session->white = NULL;
    }
    session->settings = settings;
    return true;
}

/* --- color ------------------------------------------------------------------------------------------------- */

static bool read_name(const struct place *root, const char *key, char text[128])
{
    struct place place = place_member(root, key);
    const char *value;
    if (!place.value)
        return true;
    if (!read_text(&place, &value))
        return false;
    if (strlen(value) >= 128)
        return place_fail(&place, "is longer than 127 bytes");
    strcpy(text, value);
    return true;
}

/* Without a config colours still work; only images in named spaces and views need it. So it is a warning. */
static struct color_config *open_config(const struct place *root, const char *path)
{
    stokes_error why = {0};
    struct color_config *config = *path ? color_config_open(path, &why) : NULL;
    if (*path && !config)
        session_warn(root->message->session, &why);
    return config;
}

static bool read_working_space(const struct place *root, struct session_color *color)
{
    struct place matrix = place_member(root, "rgb_to_xyz");
    double m[9];
    static const struct field field = {"rgb_to_xyz", FIELD_DOUBLE, true, 0, 9, -1e6, 1e6};
    if (matrix.value) {
        stokes_error why = {0};
        if (!read_fields(root, &field, 1, m))
            return false;
        return working_space_set(&color->working_space, m, &why) || place_fail(&matrix, "%s", why.text);
    }
    if (color->config)
        return color_config_working_space(color->config, color->name, &color->working_space,
                                          root->message->err);
    working_space_rec709(&color->working_space);
    return true;
}

bool apply_color(const struct place *root)
{
    static const struct field fields[] = {
        {"exposure", FIELD_DOUBLE, false, offsetof(struct session_color, exposure), 0, -100, 100},
        {"gamma", FIELD_DOUBLE, false, offsetof(struct session_color, gamma), 0, 1e-3, 1e3},
    };
    stokes_session *session = root->message->session;
    struct session_color color = {.gamma = 1};
    struct place path_place = place_member(root, "config");
    const char *path = "";
    if ((path_place.value && !read_text(&path_place, &path)) ||
        !read_name(root, "working_space", color.name) || !read_name(root, "display", color.display) ||
        !read_name(root, "view", color.view) || !read_name(root, "look", color.look) ||
        !read_fields(root, fields, 2, &color))
        return false;
    color.config = open_config(root, path);
    bool good = read_working_space(root, &color);
    bool changes =
        memcmp(&color.working_space, &session->color.working_space, sizeof color.working_space) != 0;
    if (!good || !check_order(root, changes, "the working space")) {
        session_color_clear(&color);
        return false;
    }
    if (changes) {
        spectrum_destroy(session->white);
        session->white = NULL;
    }
    session_color_clear(&session->color);
    session->color = color;
    return true;
}
