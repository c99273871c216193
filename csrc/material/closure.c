/* Closure trees: taking them down, and asking about their inputs. */
#include <stdlib.h>

#include "material/lobe.h"

void value_node_destroy(struct value_node *v)
{
    if (!v)
        return;
    value_node_destroy(v->child[0]);
    value_node_destroy(v->child[1]);
    free(v->texture);
    free(v);
}

void color_node_destroy(struct color_node *c)
{
    if (!c)
        return;
    spectrum_destroy(c->spectrum);
    free(c->texture);
    free(c);
}

void emission_node_destroy(struct emission_node *e)
{
    if (!e)
        return;
    spectrum_destroy(e->spectrum);
    free(e->texture);
    free(e);
}

void closure_destroy(struct closure *c)
{
    if (!c)
        return;
    closure_destroy(c->child[0]);
    closure_destroy(c->child[1]);
    value_node_destroy(c->factor);
    emission_node_destroy(c->emission);
    for (int i = 0; i < CLOSURE_COLORS; i++)
        color_node_destroy(c->color[i]);
    for (int i = 0; i < CLOSURE_VALUES; i++)
        value_node_destroy(c->value[i]);
    reradiation_destroy(c->matrix);
    free(c->normal_map);
    free(c);
}

const struct spectrum *closure_spectrum(const struct closure *c, int color)
{
    return c->color[color] && !c->color[color]->texture ? c->color[color]->spectrum : NULL;
}

bool closure_color_is_present(const struct closure *c, int color)
{
    const struct spectrum *s = closure_spectrum(c, color);
    return !s || spectrum_max(s) > 0;
}

bool closure_value_is_constant(const struct closure *c, int value, float *constant)
{
    float low, high;
    if (!c->value[value]) {
        *constant = c->bsdf->value_defaults[value];
        return true;
    }
    value_bounds(c->value[value], &low, &high);
    *constant = low;
    return low == high;
}
