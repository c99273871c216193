/* A count for each object: a binary tree of names, with the sum kept. */
#include <search.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "session/session.h"

struct tally_entry {
    size_t count;
    char key[]; /* kind/name */
};

struct tally {
    void *root;
    size_t sum;
};

static int compare(const void *a, const void *b)
{
    return strcmp(((const struct tally_entry *)a)->key, ((const struct tally_entry *)b)->key);
}

struct tally *tally_create(void)
{
    return calloc(1, sizeof(struct tally));
}

void tally_destroy(struct tally *tally)
{
    if (tally)
        tdestroy(tally->root, free);
    free(tally);
}

void tally_set(struct tally *tally, const char *kind, const char *name, size_t count)
{
    size_t room = strlen(kind) + strlen(name) + 2;
    struct tally_entry *wanted = malloc(sizeof *wanted + room);
    if (!wanted)
        return;
    wanted->count = 0;
    snprintf(wanted->key, room, "%s/%s", kind, name);
    struct tally_entry **found =
        count ? tsearch(wanted, &tally->root, compare) : tfind(wanted, &tally->root, compare);
    if (!found || *found != wanted) {
        free(wanted);
        if (!found)
            return;
    }
    struct tally_entry *entry = *found;
    tally->sum += count - entry->count;
    entry->count = count;
    if (count == 0) {
        tdelete(entry, &tally->root, compare);
        free(entry);
    }
}

size_t tally_sum(const struct tally *tally)
{
    return tally->sum;
}
