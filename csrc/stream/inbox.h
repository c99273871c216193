/* The parent's frames, read by a thread of their own, so that `cancel`, `quit` and the end of input are seen while the
   session renders. Frames stay in order; a frame's number is its place in the stream, from 0. */
#ifndef STREAM_INBOX_H
#define STREAM_INBOX_H

#include "stream/frame.h"

struct inbox;

/* NULL without memory or thread. `fd` is borrowed. */
struct inbox *inbox_open(int fd);
/* Ends the thread, also in the midst of a frame. */
void inbox_close(struct inbox *);

/* The next frame, yours (frame_free), and its number; waits for it. END after `quit` was taken is not told apart from the
   end of input; BROKEN comes once, and nothing after it. */
enum frame_result inbox_take(struct inbox *, struct stream_frame *, uint64_t *number, stokes_error *err);

/* True if a render that frame `number` asked for has to stop: a later `cancel` has come, or `quit`, or the input has ended. */
bool inbox_stops(struct inbox *, uint64_t number);

#endif
