/* The inbox: one thread reads frames into a list; the session's thread takes them out. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>
#include <unistd.h>

#include "base/os.h"
#include "stream/inbox.h"

#define WAIT_S 0.02 /* how long the end of the inbox, or a parent's death, may stay unseen */
#define GRACE_S 2.0 /* how long the process may live after its input has ended */

struct letter {
    struct letter *next;
    struct stream_frame frame;
    uint64_t number;
};

struct inbox {
    pthread_t thread;
    int fd;
    long parent;
    atomic_bool closing;
    atomic_bool ended;                /* no render goes on: quit, end of input, or a broken frame */
    _Atomic uint64_t cancelled_below; /* renders with a smaller number are cancelled */

    pthread_mutex_t lock;
    pthread_cond_t arrived;
    struct letter *first, **last; /* guarded by the lock, as all below */
    enum frame_result result;     /* READ while frames may come; else why none do */
    stokes_error err;
};

/* Without the parent there is nobody to render for; its other children may hold the pipe open, so its end is not enough. */
static bool is_orphan(const struct inbox *inbox)
{
    return os_parent() != inbox->parent;
}

static size_t pipe_source(void *user, void *data, size_t bytes)
{
    struct inbox *inbox = user;
    size_t have = 0;
    while (have < bytes) {
        while (!os_readable(inbox->fd, WAIT_S))
            if (atomic_load(&inbox->closing) || is_orphan(inbox))
                return have;
        size_t got = os_read_some(inbox->fd, (char *)data + have, bytes - have);
        if (got == 0)
            break;
        have += got;
    }
    return have;
}

static void put(struct inbox *inbox, struct letter *letter)
{
    pthread_mutex_lock(&inbox->lock);
    *inbox->last = letter;
    inbox->last = &letter->next;
    pthread_cond_signal(&inbox->arrived);
    pthread_mutex_unlock(&inbox->lock);
}

static void end(struct inbox *inbox, enum frame_result result, const stokes_error *err)
{
    atomic_store(&inbox->ended, true);
    pthread_mutex_lock(&inbox->lock);
    inbox->result = result;
    inbox->err = *err;
    pthread_cond_signal(&inbox->arrived);
    pthread_mutex_unlock(&inbox->lock);
}

/* Nothing is left to be answered. Whatever the session is busy with (a large scene's tree, a pipe that nobody reads) must not
   keep the process alive; it has no files open for writing. */
static void leave_if_stuck(struct inbox *inbox)
{
    double deadline = os_seconds() + GRACE_S;
    while (!atomic_load(&inbox->closing)) {
        if (os_seconds() > deadline)
            _exit(1);
        nanosleep(&(struct timespec){.tv_nsec = (long)(WAIT_S * 1e9)}, NULL);
    }
}

static void *read_letters(void *user)
{
    struct inbox *inbox = user;
    stokes_error err = {.object = "stream", .text = "out of memory"};
    enum frame_result result = FRAME_BROKEN;
    for (uint64_t number = 0;; number++) {
        struct letter *letter = calloc(1, sizeof *letter);
        if (!letter)
            break;
        result = frame_read(pipe_source, inbox, &letter->frame, &err);
        if (result != FRAME_READ) {
            free(letter);
            break;
        }
        bool quits = strcmp(letter->frame.name, "quit") == 0;
        if (quits)
            atomic_store(&inbox->ended, true);
        if (strcmp(letter->frame.name, "cancel") == 0)
            atomic_store(&inbox->cancelled_below, number);
        letter->number = number;
        put(inbox, letter);
        if (quits) {
            result = FRAME_END;
            break;
        }
    }
    end(inbox, result, &err);
    leave_if_stuck(inbox);
    return NULL;
}

struct inbox *inbox_open(int fd)
{
    struct inbox *inbox = calloc(1, sizeof *inbox);
    if (!inbox)
        return NULL;
    inbox->fd = fd;
    inbox->parent = os_parent();
    inbox->last = &inbox->first;
    inbox->result = FRAME_READ;
    pthread_mutex_init(&inbox->lock, NULL);
    pthread_cond_init(&inbox->arrived, NULL);
    if (pthread_create(&inbox->thread, NULL, read_letters, inbox) == 0)
        return inbox;
    pthread_cond_destroy(&inbox->arrived);
    pthread_mutex_destroy(&inbox->lock);
    free(inbox);
    return NULL;
}

void inbox_close(struct inbox *inbox)
{
    if (!inbox)
        return;
    atomic_store(&inbox->closing, true);
    pthread_join(inbox->thread, NULL);
    while (inbox->first) {
        struct letter *letter = inbox->first;
        inbox->first = letter->next;
        frame_free(&letter->frame);
        free(letter);
    }
    pthread_cond_destroy(&inbox->arrived);
    pthread_mutex_destroy(&inbox->lock);
    free(inbox);
}

enum frame_result inbox_take(struct inbox *inbox, struct stream_frame *frame, uint64_t *number,
                             stokes_error *err)
{
    pthread_mutex_lock(&inbox->lock);
    while (!inbox->first && inbox->result == FRAME_READ)
        pthread_cond_wait(&inbox->arrived, &inbox->lock);
    struct letter *letter = inbox->first;
    enum frame_result result = letter ? FRAME_READ : inbox->result;
    if (letter) {
        inbox->first = letter->next;
        if (!inbox->first)
            inbox->last = &inbox->first;
    } else if (result == FRAME_BROKEN) {
        *err = inbox->err;
        inbox->result = FRAME_END;
    }
    pthread_mutex_unlock(&inbox->lock);
    if (letter) {
        *frame = letter->frame;
        *number = letter->number;
        free(letter);
    }
    return result;
}

bool inbox_stops(struct inbox *inbox, uint64_t number)
{
    return atomic_load_explicit(&inbox->ended, memory_order_relaxed) ||
           number < atomic_load_explicit(&inbox->cancelled_below, memory_order_relaxed);
}
