/* The one C++ file: a thin extern "C" face over OpenColorIO. No exception leaves it; every error names the
   config's path. */
#include <OpenColorIO/OpenColorIO.h>

#include <cmath>
#include <cstring>
#include <exception>
#include <string>

extern "C" {
#include "base/error.h"
#include "color/color.h"
}

namespace OCIO = OCIO_NAMESPACE;

struct color_config {
    std::string path;
    OCIO::ConstConfigRcPtr config;
};

/* Runs `work`, which returns bool, and turns what it throws into an error of this config. */
template <typename Work>
static bool guarded(const char *path, const char *property, stokes_error *err, Work work) noexcept
{
    try {
        return work();
    } catch (const std::exception &e) {
        return fail(err, path, property, "%s", e.what());
    } catch (...) {
        return fail(err, path, property, "OpenColorIO failed without saying why");
    }
}

struct color_config *color_config_open(const char *path, stokes_error *err)
{
    struct color_config *made = nullptr;
    bool ok = guarded(path, "color config", err, [&] {
        OCIO::SetLoggingLevel(OCIO::LOGGING_LEVEL_NONE);
        auto config = OCIO::Config::CreateFromFile(path);
        made = new color_config{path, config};
        return true;
    });
    return ok ? made : nullptr;
}

void color_config_close(struct color_config *config)
{
    delete config;
}

/* The name OpenColorIO knows it by, or NULL: a colour space, an alias or a role. */
static const char *known_space(const OCIO::ConstConfigRcPtr &config, const char *name)
{
    if (!name || !*name)
        return nullptr;
    auto space = config->getColorSpace(name);
    return space ? space->getName() : nullptr;
}

static const char *working_name(const OCIO::ConstConfigRcPtr &config, const char *wanted)
{
    const char *name = known_space(config, wanted);
    if (!name)
        name = known_space(config, OCIO::ROLE_SCENE_LINEAR);
    if (!name)
        throw OCIO::Exception("it has no scene_linear role");
    return name;
}

/* A processor into XYZ relative to D65: the role made for it, or ACES2065-1 and on by the standard's own matrix
   (configs up to Blender 4), or the config's space of that name. */
static OCIO::ConstProcessorRcPtr processor_to_xyz(const OCIO::ConstConfigRcPtr &config, const char *from)
{
    if (config->hasRole("cie_xyz_d65_interchange"))
        return config->getProcessor(from, "cie_xyz_d65_interchange");
    if (config->hasRole("aces_interchange")) {
        auto both = OCIO::GroupTransform::Create();
        auto to_aces = OCIO::ColorSpaceTransform::Create();
        to_aces->setSrc(from);
        to_aces->setDst("aces_interchange");
        auto to_xyz = OCIO::BuiltinTransform::Create();
        to_xyz->setStyle("UTILITY - ACES-AP0_to_CIE-XYZ-D65_BFD");
        both->appendTransform(to_aces);
        both->appendTransform(to_xyz);
        return config->getProcessor(both);
    }
    for (const char *name : {"XYZ", "CIE-XYZ-D65", "Linear CIE-XYZ D65", "cie_xyz_d65"})
        if (known_space(config, name))
            return config->getProcessor(from, name);
    throw OCIO::Exception(
        "it names no CIE XYZ space (neither role cie_xyz_d65_interchange nor aces_interchange)");
}

/* The matrix of a processor from RGB to XYZ, by its values at the unit vectors. */
static bool linear_matrix(const OCIO::ConstCPUProcessorRcPtr &cpu, double matrix[9])
{
    float probe[5][3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}, {0.25f, 0.5f, 0.125f}};
    for (auto &pixel : probe)
        cpu->applyRGB(pixel);
    for (int row = 0; row < 3; row++) {
        for (int column = 0; column < 3; column++)
            matrix[3 * row + column] = probe[column][row];
        double expected = 0.25 * probe[0][row] + 0.5 * probe[1][row] + 0.125 * probe[2][row];
        if (!(std::fabs(probe[3][row]) < 1e-6) || !(std::fabs(probe[4][row] - expected) < 1e-5))
            return false;
    }
    return true;
}

bool color_config_working_space(const struct color_config *config, const char *working_space,
                                struct working_space *space, stokes_error *err)
{
    const char *path = config->path.c_str();
    return guarded(path, "working space", err, [&] {
        const char *name = working_name(config->config, working_space);
        double matrix[9];
        auto cpu = processor_to_xyz(config->config, name)->getDefaultCPUProcessor();
        if (!linear_matrix(cpu, matrix))
            return fail(err, path, "working space", "%s is not linear in CIE XYZ", name);
        return working_space_set(space, matrix, err);
    });
}

static void apply(const OCIO::ConstProcessorRcPtr &processor, float *pixels, size_t count, int stride)
{
    if (processor->isNoOp() || !count)
        return;
    auto cpu = processor->getOptimizedCPUProcessor(OCIO::OPTIMIZATION_LOSSLESS);
    const ptrdiff_t pixel_bytes = stride * (ptrdiff_t)sizeof(float);
    OCIO::PackedImageDesc image(pixels, (long)count, 1, stride >= 4 ? 4 : 3, OCIO::BIT_DEPTH_F32,
                                sizeof(float), pixel_bytes, pixel_bytes * (ptrdiff_t)count);
    cpu->apply(image);
}

bool color_config_to_working(const struct color_config *config, const char *colorspace,
                             const char *working_space, float *pixels, size_t count, int stride,
                             stokes_error *err)
{
    const char *path = config->path.c_str();
    return guarded(path, "color space", err, [&] {
        const char *from = known_space(config->config, colorspace);
        if (!from)
            return fail(err, path, "color space", "it has no space named %s", colorspace);
        apply(config->config->getProcessor(from, working_name(config->config, working_space)), pixels, count,
              stride);
        return true;
    });
}

/* A display transform behind exposure (stops), before gamma, as Blender's colour management does it. */
static OCIO::ConstProcessorRcPtr display_processor(const OCIO::ConstConfigRcPtr &config, const char *from,
                                                   const char *display, const char *view, const char *look,
                                                   double exposure, double gamma)
{
    auto chain = OCIO::GroupTransform::Create();
    if (exposure != 0) {
        double gain = std::exp2(exposure), m[16] = {gain, 0, 0, 0, 0, gain, 0, 0, 0, 0, gain, 0, 0, 0, 0, 1};
        auto scale = OCIO::MatrixTransform::Create();
        scale->setMatrix(m);
        chain->appendTransform(scale);
    }
    std::string input = from;
    if (look && *look && std::strcmp(look, "None") != 0) {
        const char *result =
            OCIO::LookTransform::GetLooksResultColorSpace(config, config->getCurrentContext(), look);
        auto looks = OCIO::LookTransform::Create();
        looks->setSrc(from);
        looks->setDst(result && *result ? result : from);
        looks->setLooks(look);
        chain->appendTransform(looks);
        input = looks->getDst();
    }
    auto to_display = OCIO::DisplayViewTransform::Create();
    to_display->setSrc(input.c_str());
    to_display->setDisplay(display && *display ? display : config->getDefaultDisplay());
    to_display->setView(view && *view ? view : config->getDefaultView(to_display->getDisplay()));
    to_display->setLooksBypass(look && *look && std::strcmp(look, "None") != 0);
    chain->appendTransform(to_display);
    if (gamma > 0 && gamma != 1) {
        double power[4] = {1 / gamma, 1 / gamma, 1 / gamma, 1};
        auto exponent = OCIO::ExponentTransform::Create();
        exponent->setValue(power);
        chain->appendTransform(exponent);
    }
    return config->getProcessor(chain);
}

bool color_config_to_display(const struct color_config *config, const char *working_space,
                             const char *display, const char *view, const char *look, double exposure,
                             double gamma, float *pixels, size_t count, int stride, stokes_error *err)
{
    return guarded(config->path.c_str(), "display", err, [&] {
        const char *from = working_name(config->config, working_space);
        apply(display_processor(config->config, from, display, view, look, exposure, gamma), pixels, count,
              stride);
        for (size_t i = 0; i < count; i++)
            for (int c = 0; c < 3; c++) {
                float value = pixels[i * (size_t)stride + (size_t)c];
                pixels[i * (size_t)stride + (size_t)c] = value > 0 ? value < 1 ? value : 1 : 0;
            }
        return true;
    });
}
