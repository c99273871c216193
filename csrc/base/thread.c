/* Running units of work on several threads: one shared counter hands them out, so that a slow unit holds up no other.
   Worker 0 is the calling thread. */
#include <pthread.h>
#include <stdatomic.h>
#include <stdlib.h>

#include "base/thread.h"

struct crew {
    atomic_size_t next;
    size_t count;
    thread_work work;
    bool (*stop)(void *context);
    void *context;
};

struct worker {
    struct crew *crew;
    pthread_t thread;
    int number;
};

static void work_until_done(struct crew *crew, int number)
{
    while (!crew->stop || !crew->stop(crew->context)) {
        size_t index = atomic_fetch_add_explicit(&crew->next, 1, memory_order_relaxed);
        if (index >= crew->count)
            return;
        crew->work(crew->context, index, number);
    }
}

static void *worker_main(void *data)
{
    struct worker *worker = data;
    work_until_done(worker->crew, worker->number);
    return NULL;
}

void thread_run(int threads, size_t count, thread_work work, bool (*stop)(void *context), void *context)
{
    struct crew crew = {.count = count, .work = work, .stop = stop, .context = context};
    size_t helpers = threads > 1 ? (size_t)threads - 1 : 0;
    if (helpers >= count)
        helpers = count ? count - 1 : 0;
    struct worker *worker = helpers ? calloc(helpers, sizeof *worker) : NULL;
    size_t started = 0;
    /* A thread that cannot be had is work for the others. */
    for (; worker && started < helpers; started++) {
        worker[started] = (struct worker){.crew = &crew, .number = (int)started + 1};
        if (pthread_create(&worker[started].thread, NULL, worker_main, &worker[started]) != 0)
            break;
    }
    work_until_done(&crew, 0);
    for (size_t i = 0; i < started; i++)
        pthread_join(worker[i].thread, NULL);
    free(worker);
}
