/* Vectors of three floats, orthonormal frames and 3×4 transforms. */
#ifndef BASE_VEC_H
#define BASE_VEC_H

#include <math.h>
#include <stdbool.h>

#define PI_F 3.14159265358979f

struct vec2 {
    float x, y;
};

struct vec3 {
    float x, y, z;
};

static inline struct vec3 vec3(float x, float y, float z) { return (struct vec3){x, y, z}; }
static inline struct vec3 add(struct vec3 a, struct vec3 b) { return vec3(a.x + b.x, a.y + b.y, a.z + b.z); }
static inline struct vec3 sub(struct vec3 a, struct vec3 b) { return vec3(a.x - b.x, a.y - b.y, a.z - b.z); }
static inline struct vec3 scale(struct vec3 a, float k) { return vec3(a.x * k, a.y * k, a.z * k); }
static inline struct vec3 negate(struct vec3 a) { return vec3(-a.x, -a.y, -a.z); }
static inline float dot(struct vec3 a, struct vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline struct vec3 cross(struct vec3 a, struct vec3 b)
{
    return vec3(a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x);
}
static inline float length_squared(struct vec3 a) { return dot(a, a); }
static inline float length(struct vec3 a) { return sqrtf(dot(a, a)); }
static inline struct vec3 normalize(struct vec3 a)
{
    float l = length(a);
    return l > 0 ? scale(a, 1 / l) : vec3(0, 0, 0);
}
/* a + k b */
static inline struct vec3 along(struct vec3 a, struct vec3 b, float k)
{
    return vec3(a.x + k * b.x, a.y + k * b.y, a.z + k * b.z);
}
static inline bool is_finite(struct vec3 a) { return isfinite(a.x) && isfinite(a.y) && isfinite(a.z); }
static inline float clampf(float x, float low, float high) { return x < low ? low : x > high ? high : x; }
static inline float lerpf(float a, float b, float t) { return a + (b - a) * t; }

/* An orthonormal frame about n (Duff et al. 2017, "Building an orthonormal basis, revisited"). */
struct frame {
    struct vec3 s, t, n;
};

static inline struct frame frame_about(struct vec3 n)
{
    float sign = copysignf(1.0f, n.z), a = -1.0f / (sign + n.z), b = n.x * n.y * a;
    return (struct frame){vec3(1 + sign * n.x * n.x * a, sign * b, -sign * n.x), vec3(b, sign + n.y * n.y * a, -n.y),
                          n};
}
static inline struct vec3 to_world(const struct frame *f, struct vec3 v)
{
    return along(along(scale(f->s, v.x), f->t, v.y), f->n, v.z);
}
static inline struct vec3 to_local(const struct frame *f, struct vec3 v)
{
    return vec3(dot(f->s, v), dot(f->t, v), dot(f->n, v));
}

/* Rows of a 3×4 affine matrix. */
struct transform {
    float m[12];
};

static inline struct vec3 transform_point(const struct transform *t, struct vec3 p)
{
    const float *m = t->m;
    return vec3(m[0] * p.x + m[1] * p.y + m[2] * p.z + m[3], m[4] * p.x + m[5] * p.y + m[6] * p.z + m[7],
                m[8] * p.x + m[9] * p.y + m[10] * p.z + m[11]);
}
static inline struct vec3 transform_vector(const struct transform *t, struct vec3 v)
{
    const float *m = t->m;
    return vec3(m[0] * v.x + m[1] * v.y + m[2] * v.z, m[4] * v.x + m[5] * v.y + m[6] * v.z,
                m[8] * v.x + m[9] * v.y + m[10] * v.z);
}

/* A direction about +z with density cos θ/π per solid angle, i.e. 1/π per projected solid angle. */
static inline struct vec3 cosine_hemisphere(float u, float v)
{
    float r = sqrtf(u), phi = 2 * PI_F * v;
    return vec3(r * cosf(phi), r * sinf(phi), sqrtf(fmaxf(0, 1 - u)));
}

#endif
