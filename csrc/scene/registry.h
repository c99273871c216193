/* Named things of one kind: a hash table whose entries can also be walked by name, so that what is built from
   them depends on the scene alone and not on the order of its messages. */
#ifndef SCENE_REGISTRY_H
#define SCENE_REGISTRY_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct registry_entry {
    const char *name; /* borrowed from the item, which holds its own name */
    void *item;
};
struct registry {
    struct registry_entry *entry; /* unordered, dense */
    size_t count, capacity;
    uint32_t *slot; /* index into entry + 1; 0 is free; open addressing */
    size_t slot_count;
    bool sorted;
};

void registry_free(struct registry *); /* not the items */
void *registry_find(const struct registry *, const char *name);
/* Puts an item under its name; *old is what bore the name, or NULL. False: no memory, nothing changed. */
bool registry_put(struct registry *, const char *name, void *item, void **old);
/* Takes an item out; NULL if there is none. */
void *registry_take(struct registry *, const char *name);
/* Sorts the entries by name. */
void registry_sort(struct registry *);

#endif
