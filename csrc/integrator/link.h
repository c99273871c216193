/* What a cut's density has beside its two sub-paths: who drew the wavelength of the connecting run, and 1/G of the edge. */
#ifndef INTEGRATOR_LINK_H
#define INTEGRATOR_LINK_H

#include "integrator/mis.h"

/* Where the run of each vertex starts, seen from either end, and whether the part of it that lies between disperses. */
struct chart {
    struct chart_end {
        int start;      /* the F vertex, light or camera where the run begins on that side */
        bool disperses; /* some vertex between it and this one does */
    } from_light[FULL_PATH_VERTICES], from_camera[FULL_PATH_VERTICES];
};

void chart_runs(const struct full_path *, struct chart *);

/* 0 where the cut is impossible. `chart` is read for exact connections only. */
double link_factor(const struct integrator *, const struct full_path *, const struct chart *, int cut);

/* Nominal chances of copying (algorithm.md §9): of an own wavelength, and of that of the camera's run k. Constants of the scene. */
double copy_own_chance(const struct integrator *);
double copy_run_chance(const struct integrator *, int run);

#endif
