/* Tables of directional albedo of GGX lobes, for what depends on it: layering and energy compensation in Principled. A
   table belongs to one compiled closure: its index is known, and where its roughness is too, a row is all there is. */
#ifndef MATERIAL_ALBEDO_H
#define MATERIAL_ALBEDO_H

#include "material/lobe.h"

struct albedo_table;

/* What is averaged over the visible normals: 1; the share of the way from F0 to 1 that dielectric Fresnel goes, relative to
   that 1 (s of F = F0 + s (1 − F0)); reflection and refraction together, entering an index (or leaving it for vacuum: 1/ior). */
enum albedo_of { ALBEDO_WHITE, ALBEDO_FRESNEL_SHARE, ALBEDO_GLASS };

/* For all that a closure's roughness input can say: one row if it is constant. NULL when memory runs out. */
struct albedo_table *albedo_table_create(enum albedo_of, float ior, const struct closure *, int roughness);
void albedo_table_destroy(struct albedo_table *);
float albedo_at(const struct albedo_table *, float roughness, float cosine);
/* The mean over the hemisphere, ∫ 2 cos E d cos. */
float albedo_mean(const struct albedo_table *, float roughness);

/* What single-scattering GGX loses, given back by scaling the lobe (Turquin 2019): its albedo e becomes e + F_ms (1 − e), where
   F_ms is the colour of further bounces between facets that keep a share f each (Kulla & Conty 2017). 1 without a table. */
float albedo_compensation(const struct albedo_table *, float roughness, float cosine, float facets);

#endif
