/* Running a function over a range of small units of work on several threads. */
#ifndef BASE_THREAD_H
#define BASE_THREAD_H

#include <stdbool.h>
#include <stddef.h>

/* Work on unit `index`, by worker `worker` in [0, threads); worker 0 is the thread that called thread_run. */
typedef void (*thread_work)(void *context, size_t index, int worker);

/* Calls work for every index in [0, count), each once, in any order; returns when all are done. `stop`, asked
   before each unit, may be NULL; true skips the rest. threads <= 1 runs on the calling thread. */
void thread_run(int threads, size_t count, thread_work work, bool (*stop)(void *context), void *context);

/* Processors that this process may use. */
int thread_processors(void);

#endif
