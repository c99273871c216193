/* A new integrator is one line here if it is a set of techniques over the same path code. */
#include "integrator/kinds.h"

#include <string.h>

static bool hits_lights(int s, int t)
{
    return s == 0 && t >= 2;
}
static bool hits_or_connects_to_lights(int s, int t)
{
    return s <= 1 && t >= 2;
}
static bool connects_to_the_camera(int s, int t)
{
    return s >= 1 && t == 1;
}
static bool everything(int s, int t)
{
    return t >= 2 || (s >= 1 && t == 1);
}

static const struct integrator_kind kinds[] = {
    {"pt", hits_lights, true},
    {"pt_nee", hits_or_connects_to_lights, true},
    {"lt", connects_to_the_camera, true},
    {"mbdpt", everything, false}, /* Jung, Hanika, Dachsbacher 2020 */
    {"bdpt", everything, true},   /* algorithm.md §9 */
};

const struct integrator_kind *integrator_kind_at(size_t index)
{
    return index < sizeof kinds / sizeof *kinds ? &kinds[index] : NULL;
}

const struct integrator_kind *integrator_kind_find(const char *name)
{
    for (size_t i = 0; i < sizeof kinds / sizeof *kinds; i++)
        if (strcmp(kinds[i].name, name) == 0)
            return &kinds[i];
    return NULL;
}
