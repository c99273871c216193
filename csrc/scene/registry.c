/* Named things of one kind: open addressing over a dense list of entries.
   Removal rebuilds the slots lazily: the last entry takes the removed one's place. */
#include "scene/registry.h"

#include <stdlib.h>
#include <string.h>

static uint64_t hash_name(const char *name)
{
    uint64_t hash = 0xcbf29ce484222325u; /* FNV-1a */
    for (; *name; name++)
        hash = (hash ^ (unsigned char)*name) * 0x100000001b3u;
    return hash ^ hash >> 32;
}

void registry_free(struct registry *registry)
{
    free(registry->entry);
    free(registry->slot);
    *registry = (struct registry){0};
}

static void fill_slots(struct registry *registry)
{
    memset(registry->slot, 0, registry->slot_count * sizeof *registry->slot);
    for (size_t i = 0; i < registry->count; i++) {
        size_t at = hash_name(registry->entry[i].name) & (registry->slot_count - 1);
        while (registry->slot[at])
            at = (at + 1) & (registry->slot_count - 1);
        registry->slot[at] = (uint32_t)i + 1;
    }
}

/* The slot that holds the name, or the free one where it would go. */
static size_t find_slot(const struct registry *registry, const char *name)
{
    size_t at = hash_name(name) & (registry->slot_count - 1);
    while (registry->slot[at] && strcmp(registry->entry[registry->slot[at] - 1].name, name) != 0)
        at = (at + 1) & (registry->slot_count - 1);
    return at;
}

static bool grow(struct registry *registry)
{
    size_t capacity = registry->capacity ? 2 * registry->capacity : 16;
    struct registry_entry *entry = realloc(registry->entry, capacity * sizeof *entry);
    if (!entry)
        return false;
    registry->entry = entry;
    uint32_t *slot = malloc(2 * capacity * sizeof *slot);
    if (!slot)
        return false;
    free(registry->slot);
    registry->slot = slot;
    registry->slot_count = 2 * capacity;
    registry->capacity = capacity;
    fill_slots(registry);
    return true;
}

void *registry_find(const struct registry *registry, const char *name)
{
    if (!registry->slot_count)
        return NULL;
    uint32_t index = registry->slot[find_slot(registry, name)];
    return index ? registry->entry[index - 1].item : NULL;
}

bool registry_put(struct registry *registry, const char *name, void *item, void **old)
{
    *old = NULL;
    if (registry->count == registry->capacity && !grow(registry))
        return false;
    size_t at = find_slot(registry, name);
    if (registry->slot[at]) {
        struct registry_entry *entry = &registry->entry[registry->slot[at] - 1];
        *old = entry->item;
        *entry = (struct registry_entry){name, item};
        return true;
    }
    registry->entry[registry->count++] = (struct registry_entry){name, item};
    registry->slot[at] = (uint32_t)registry->count;
    registry->sorted = false;
    return true;
}

/* Frees a slot and closes the gap in the run of entries after it, so that no probe ends early. */
static void free_slot(struct registry *registry, size_t hole)
{
    size_t mask = registry->slot_count - 1;
    for (size_t at = (hole + 1) & mask; registry->slot[at]; at = (at + 1) & mask) {
        size_t home = hash_name(registry->entry[registry->slot[at] - 1].name) & mask;
        if (((at - home) & mask) >= ((at - hole) & mask)) {
            registry->slot[hole] = registry->slot[at];
            hole = at;
        }
    }
    registry->slot[hole] = 0;
}

void *registry_take(struct registry *registry, const char *name)
{
    if (!registry->slot_count)
        return NULL;
    size_t at = find_slot(registry, name);
    if (!registry->slot[at])
        return NULL;
    size_t index = registry->slot[at] - 1, last = registry->count - 1;
    void *item = registry->entry[index].item;
    size_t last_at = find_slot(registry, registry->entry[last].name);
    registry->slot[last_at] = (uint32_t)index + 1;
    if (last_at == at)
        registry->slot[at] = (uint32_t)last + 1;
    free_slot(registry, at);
    registry->entry[index] = registry->entry[last];
    registry->count = last;
    registry->sorted = false;
    return item;
}

static int by_name(const void *a, const void *b)
{
    const struct registry_entry *x = a, *y = b;
    return strcmp(x->name, y->name);
}

void registry_sort(struct registry *registry)
{
    if (registry->sorted || !registry->count)
        return;
    qsort(registry->entry, registry->count, sizeof *registry->entry, by_name);
    fill_slots(registry);
    registry->sorted = true;
}
