/* The world: constant, or an image over all directions in Cycles' equirectangular layout. Directions of an
   image world are drawn by luminance and solid angle. */
#include <stdlib.h>
#include <string.h>

#include "base/error.h"
#include "scene/state.h"

/* Cells of the importance map; a wider image's texels share them. */
#define MAP_WIDTH_MAX 2048u
#define MAP_HEIGHT_MAX 1024u

struct world_map {
    uint32_t width, height;
    float *value;                 /* density of a cell's directions, times `total` */
    double *row_sum, *column_sum; /* height + 1; width + 1 for each row */
    double total;
    float mean[3]; /* colour over the sphere */
};

static void map_destroy(struct world_map *map)
{
    if (!map)
        return;
    free(map->value);
    free(map->row_sum);
    free(map->column_sum);
    free(map);
}

void world_destroy(struct world *world)
{
    if (!world)
        return;
    emission_free(&world->emission);
    emission_node_destroy(world->input.emission);
    volume_destroy(world->input.volume);
    map_destroy(world->map);
    free(world->image_name);
    free(world);
}

static bool check(const struct world_input *in, struct world *world, stokes_error *err)
{
    if (in->emission)
        return !in->emission->texture || fail(err, "world", "emission", "a texture is for an image world");
    if (!in->image)
        return fail(err, "world", "emission", "missing");
    if (!(in->scale >= 0 && isfinite(in->scale)))
        return fail(err, "world", "scale", "is %g", (double)in->scale);
    world->determinant = (float)fabs(transform_determinant(&in->to_map));
    return transform_inverse(&in->to_map, &world->from_map) ||
           fail(err, "world", "transform", "has no inverse");
}

bool scene_set_world(struct scene *scene, const struct world_input *in, stokes_error *err)
{
    struct world *world = calloc(1, sizeof *world);
    if (!world || (in->image && !(world->image_name = copy_text(in->image)))) {
        free(world);
        emission_node_destroy(in->emission);
        volume_destroy(in->volume);
        return fail(err, "world", "image", "no memory");
    }
    world->input = *in;
    world->input.image = world->image_name;
    world->mask = visibility_mask(in->visible);
    if (!check(in, world, err)) {
        world_destroy(world);
        return false;
    }
    world_destroy(scene->world);
    scene->world = world;
    scene->lights_dirty = true;
    scene->committed = false;
    return true;
}

/* --- Directions -------------------------------------------------------------------------------------- */

/* Cycles' equirectangular layout: u falls with the angle about z, v = 1 at +z. */
static void direction_to_map(struct vec3 d, float uv[2])
{
    uv[0] = 0.5f - atan2f(d.y, d.x) / (2 * PI_F);
    uv[1] = 0.5f + atan2f(d.z, hypotf(d.x, d.y)) / PI_F;
}

static double height_at(double v)
{
    return -cos(PI_F * v); /* z of the unit sphere */
}

static struct vec3 all_directions(const float u[2])
{
    float z = 1 - 2 * u[0], phi = 2 * PI_F * u[1], r = sqrtf(fmaxf(0, 1 - z * z));
    return vec3(r * cosf(phi), r * sinf(phi), z);
}

static float map_pdf(const struct world_map *map, struct vec3 d)
{
    float uv[2];
    direction_to_map(d, uv);
    int64_t x = (int64_t)(uv[0] * (float)map->width), y = (int64_t)(uv[1] * (float)map->height);
    x = x < 0 ? 0 : x >= map->width ? map->width - 1 : x;
    y = y < 0 ? 0 : y >= map->height ? map->height - 1 : y;
    return (float)(map->value[(size_t)y * map->width + (size_t)x] / map->total);
}

static struct vec3 map_sample(const struct world_map *map, const float u[2])
{
    double in_row, in_column;
    size_t row = search_sum(map->row_sum, map->height, u[0], &in_row);
    const double *columns = map->column_sum + row * (map->width + 1);
    size_t column = search_sum(columns, map->width, u[1], &in_column);
    double low = height_at((double)row / map->height), high = height_at((double)(row + 1) / map->height);
    float z = (float)(low + in_row * (high - low));
    float phi = 2 * PI_F * (float)(0.5 - ((double)column + in_column) / map->width);
    float r = sqrtf(fmaxf(0, 1 - z * z));
    return vec3(r * cosf(phi), r * sinf(phi), z);
}

float world_pdf(const struct world *world, struct vec3 direction)
{
    if (!world->map)
        return 1 / (4 * PI_F);
    /* A linear map A of directions has the Jacobian |det A| / |A ω|³. */
    struct vec3 d = transform_vector(&world->input.to_map, direction);
    float stretch = length(d);
    return map_pdf(world->map, d) * world->determinant / (stretch * stretch * stretch);
}

struct vec3 world_sample(const struct world *world, const float u[2])
{
    if (!world->map)
        return all_directions(u);
    return normalize(transform_vector(&world->from_map, map_sample(world->map, u)));
}

float world_radiance(const struct world *world, struct vec3 direction, float lambda)
{
    float uv[2] = {0, 0};
    if (world->map)
        direction_to_map(transform_vector(&world->input.to_map, direction), uv);
    return emission_at(&world->emission, vec3(uv[0], uv[1], 0), lambda);
}

/* --- The importance map ------------------------------------------------------------------------------ */

/* Luminance, and a part of the strongest channel, so that no colour is without support. */
static float importance(const float rgba[4], const float luminance[3])
{
    float sum = 0, most = 0;
    for (int i = 0; i < 3; i++) {
        sum += rgba[i] > 0 ? fmaxf(0, luminance[i]) * rgba[i] : 0;
        most = fmaxf(most, rgba[i]);
    }
    return 0.75f * sum + 0.25f * most;
}

/* ∫ over cell [first, end) of the linear interpolation of texels: each counts 1, 1/8 of it falls over each
   edge. */
static float overlap(int64_t i, int64_t first, int64_t end)
{
    if (i < first || i >= end)
        return 0.125f;
    return 1 - (i == first ? 0.125f : 0) - (i == end - 1 ? 0.125f : 0);
}

struct cell_range {
    int64_t first, end;
};
static struct cell_range cell_texels(uint32_t cell, uint32_t cells, uint32_t texels)
{
    return (struct cell_range){(int64_t)cell * texels / cells,
                               ((int64_t)(cell + 1) * texels + cells - 1) / cells};
}

/* Sums `count` values with a stride over a cell, wrapping round. */
static float cell_sum(const float *value, size_t stride, uint32_t count, struct cell_range range)
{
    float sum = 0;
    for (int64_t i = range.first - 1; i <= range.end; i++)
        sum += overlap(i, range.first, range.end) * value[(size_t)((i + count) % count) * stride];
    return sum / (float)(range.end - range.first);
}

/* Importance of each texel row, gathered into the map's columns. */
static bool fill_values(struct world_map *map, const struct image *image, const float luminance[3])
{
    float *texels = malloc(image->width * sizeof *texels);
    float *rows = malloc((size_t)image->height * map->width * sizeof *rows);
    for (uint32_t y = 0; texels && rows && y < image->height; y++) {
        for (uint32_t x = 0; x < image->width; x++)
            texels[x] = importance(image->rgba + 4 * ((size_t)y * image->width + x), luminance);
        for (uint32_t x = 0; x < map->width; x++)
            rows[(size_t)y * map->width + x] =
                cell_sum(texels, 1, image->width, cell_texels(x, map->width, image->width));
    }
    for (uint32_t y = 0; texels && rows && y < map->height; y++)
        for (uint32_t x = 0; x < map->width; x++)
            map->value[(size_t)y * map->width + x] =
                cell_sum(rows + x, map->width, image->height, cell_texels(y, map->height, image->height));
    bool whole = texels && rows;
    free(texels);
    free(rows);
    return whole;
}

static void fill_sums(struct world_map *map)
{
    map->row_sum[0] = 0;
    for (uint32_t y = 0; y < map->height; y++) {
        double *columns = map->column_sum + (size_t)y * (map->width + 1);
        columns[0] = 0;
        for (uint32_t x = 0; x < map->width; x++)
            columns[x + 1] = columns[x] + map->value[(size_t)y * map->width + x];
        double heights = height_at((y + 1.0) / map->height) - height_at((double)y / map->height);
        map->row_sum[y + 1] = map->row_sum[y] + columns[map->width] * heights * 2 * PI_F / map->width;
    }
    map->total = map->row_sum[map->height];
}

static void fill_mean(struct world_map *map, const struct image *image)
{
    double mean[3] = {0};
    for (uint32_t y = 0; y < image->height; y++) {
        double heights = height_at((y + 1.0) / image->height) - height_at((double)y / image->height),
               row[3] = {0};
        for (uint32_t x = 0; x < image->width; x++)
            for (int c = 0; c < 3; c++)
                row[c] += fmaxf(0, image->rgba[4 * ((size_t)y * image->width + x) + (size_t)c]);
        for (int c = 0; c < 3; c++)
            mean[c] += row[c] * heights / (2.0 * image->width);
    }
    for (int c = 0; c < 3; c++)
        map->mean[c] = (float)mean[c];
}

static struct world_map *map_create(const struct image *image, const float luminance[3])
{
    struct world_map *map = calloc(1, sizeof *map);
    if (!map)
        return NULL;
    map->width = image->width < MAP_WIDTH_MAX ? image->width : MAP_WIDTH_MAX;
    map->height = image->height < MAP_HEIGHT_MAX ? image->height : MAP_HEIGHT_MAX;
    size_t cells = (size_t)map->width * map->height;
    map->value = malloc(cells * sizeof *map->value);
    map->row_sum = malloc((map->height + 1) * sizeof *map->row_sum);
    map->column_sum = malloc((cells + map->height) * sizeof *map->column_sum);
    if (!map->value || !map->row_sum || !map->column_sum || !fill_values(map, image, luminance)) {
        map_destroy(map);
        return NULL;
    }
    fill_sums(map);
    fill_mean(map, image);
    return map;
}

bool world_compile(struct scene *scene, stokes_error *err)
{
    struct world *world = scene->world;
    if (!world->image_name)
        return emission_compile(&world->emission, scene, world->input.emission, NULL, "world", err);
    const struct image *image = scene_find_image(scene, world->image_name);
    if (!image)
        return fail(err, "world", "image", "there is no image named \"%.200s\"", world->image_name);
    if (scene->images_dirty || !world->map) {
        map_destroy(world->map);
        world->map = map_create(image, scene->context.luminance);
    }
    if (!world->map)
        return fail(err, "world", "image", "no memory for its importance map");
    world->texture = (struct texture){.image = image,
                                      .transform = {{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0}},
                                      .interpolation = TEXTURE_LINEAR,
                                      .extension = TEXTURE_REPEAT};
    world->node = (struct emission_node){.texture = &world->texture, .scale = world->input.scale};
    return emission_compile(&world->emission, scene, &world->node, world->map->mean, "world", err);
}
