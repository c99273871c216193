/* Sample points addressed by (seed, pixel, sample, dimension): never drawn from a running generator, so that an
   image depends on scene, seed and sample range alone. */
#ifndef BASE_RANDOM_H
#define BASE_RANDOM_H

#include <stdint.h>

/* Murmur3's 64-bit finaliser: every input bit moves every output bit. */
static inline uint64_t random_mix(uint64_t x)
{
    x = (x ^ (x >> 33)) * 0xff51afd7ed558ccdull;
    x = (x ^ (x >> 33)) * 0xc4ceb9fe1a85ec53ull;
    return x ^ (x >> 33);
}

/* The address of one path: pixel in the full frame, global sample index. */
struct random_path {
    uint64_t key;
};

static inline struct random_path random_path(uint32_t seed, uint32_t pixel, uint32_t sample)
{
    return (struct random_path){
        random_mix(random_mix(((uint64_t)seed << 32) + 0x9e3779b97f4a7c15ull) ^ ((uint64_t)pixel << 32 | sample))};
}

/* Uniform in [0, 1), 24 bits. */
static inline float random_at(struct random_path path, uint32_t dimension)
{
    return (float)(random_mix(path.key + 0x9e3779b97f4a7c15ull * (dimension + 1)) >> 40) * 0x1p-24f;
}

#endif
