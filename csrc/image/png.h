/* Writing PNG through libpng. */
#ifndef IMAGE_PNG_H
#define IMAGE_PNG_H

#include "stokes.h"

/* 8 bits a channel, RGBA with straight alpha, from display-referred floats, bottom row first. Values
   outside [0,1] are clamped; what is not finite becomes 0. The file appears whole or not at all. */
bool png_write_rgba(int width, int height, const float *rgba, const char *path, stokes_error *err);

#endif
