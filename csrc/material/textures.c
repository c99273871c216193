/* The textures of a closure tree: which there are, and whether colours are among them. */
#include <stdlib.h>

#include "material/lobe.h"

static void visit_value(const struct value_node *v, void (*visit)(void *, struct texture *, bool), void *user)
{
    if (!v)
        return;
    if (v->texture)
        visit(user, v->texture, false);
    visit_value(v->child[0], visit, user);
    visit_value(v->child[1], visit, user);
}

/* Calls visit for every texture of the tree, saying whether it is a colour. */
static void visit_textures(const struct closure *c, void (*visit)(void *, struct texture *, bool), void *user)
{
    if (!c)
        return;
    visit_value(c->factor, visit, user);
    if (c->emission && c->emission->texture)
        visit(user, c->emission->texture, true);
    for (int i = 0; i < CLOSURE_COLORS; i++)
        if (c->color[i] && c->color[i]->texture)
            visit(user, c->color[i]->texture, true);
    for (int i = 0; i < CLOSURE_VALUES; i++)
        visit_value(c->value[i], visit, user);
    if (c->normal_map)
        visit(user, c->normal_map, false);
    visit_textures(c->child[0], visit, user);
    visit_textures(c->child[1], visit, user);
}

static void note_color(void *user, struct texture *t, bool is_color)
{
    (void)t;
    *(bool *)user |= is_color;
}

bool material_needs_rgb_table(const struct closure *c)
{
    bool needs = false;
    visit_textures(c, note_color, &needs);
    return needs;
}

static void count_texture(void *user, struct texture *t, bool is_color)
{
    (void)t, (void)is_color;
    ++*(size_t *)user;
}

static void collect_texture(void *user, struct texture *t, bool is_color)
{
    (void)is_color;
    struct material *m = user;
    m->texture[m->texture_count++] = t;
}

bool material_collect_textures(struct material *m, struct compiler *c)
{
    size_t count = 0;
    visit_textures(m->closure, count_texture, &count);
    m->texture = calloc(count + 1, sizeof(struct texture *));
    if (!m->texture)
        return compiler_fail(c, "", "out of memory");
    visit_textures(m->closure, collect_texture, m);
    return true;
}

size_t material_texture_count(const struct material *m)
{
    return m->texture_count;
}
struct texture *material_texture(const struct material *m, size_t index)
{
    return m->texture[index];
}
