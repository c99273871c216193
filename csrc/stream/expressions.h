/* The stream's expressions (STREAM.md, "Conventions" and "Closures"): S, V, T, L and closure trees, read into what
   material/closure.h and spectrum.h hold. All return yours, or NULL with the message's error filled. */
#ifndef STREAM_EXPRESSIONS_H
#define STREAM_EXPRESSIONS_H

#include "material/closure.h"
#include "material/volume.h"
#include "stream/members.h"

#define EXPRESSION_DEPTH 64
#define EXPRESSION_TERMS 256 /* of a sum or a product */

/* S without textures. `beyond`: what a table says outside its own wavelengths. */
struct spectrum *read_spectrum(const struct place *, enum beyond, int depth);
/* S where a BSDF takes it. color_node_destroy. */
struct color_node *read_color(const struct place *, enum beyond, int depth);
/* V. value_node_destroy. */
struct value_node *read_value(const struct place *, int depth);
/* T. free. */
struct texture *read_texture(const struct place *);
/* L. emission_node_destroy. */
struct emission_node *read_emission(const struct place *);
/* M. reradiation_destroy. */
stokes_matrix *read_matrix(const struct place *);
/* A closure tree. closure_destroy. */
struct closure *read_closure(const struct place *, int depth);

/* W. volume_destroy. */
struct volume *read_volume(const struct place *);

/* An RGB colour that is counted when no reflectance reaches it. */
struct spectrum *rgb_spectrum(struct message *, enum rgb_method, const float rgb[3]);
struct range message_range(const struct message *);

#endif
