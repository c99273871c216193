/* Sample points addressed by (seed, pixel, sample, dimension): never drawn from a running generator, so that an image depends
   on scene, seed and sample range alone. Dimensions 2k and 2k + 1 of one pixel are an Owen-scrambled (0,2)-sequence in the sample
   index (Sobol' 1967), shuffled anew for each pair (Burley 2020, "Practical hash-based Owen scrambling"), so that the samples of a
   pixel are stratified in every dimension and in every such pair. */
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

static inline uint32_t random_reverse(uint32_t x)
{
    x = __builtin_bswap32(x);
    x = (x >> 4 & 0x0f0f0f0f) | (x & 0x0f0f0f0f) << 4;
    x = (x >> 2 & 0x33333333) | (x & 0x33333333) << 2;
    return (x >> 1 & 0x55555555) | (x & 0x55555555) << 1;
}

/* A nested uniform permutation of bit-reversed integers: bit i depends on the lower ones alone (Laine & Karras 2011; Vegdahl's
   constants). */
static inline uint32_t random_permute(uint32_t x, uint32_t seed)
{
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return x;
}

/* The Pascal matrix modulo 2, generator of the second Sobol' dimension: by Lucas, entry (i, j) is 1 where the bits of i are among
   those of j, so the product is a superset sum over GF(2). */
static inline uint32_t random_pascal(uint32_t x)
{
    x ^= (x & 0xaaaaaaaau) >> 1;
    x ^= (x & 0xccccccccu) >> 2;
    x ^= (x & 0xf0f0f0f0u) >> 4;
    x ^= (x & 0xff00ff00u) >> 8;
    return x ^ (x & 0xffff0000u) >> 16;
}

/* The address of one path: pixel in the full frame, global sample index. */
struct random_path {
    uint64_t key;
    uint32_t reversed_sample;
};

static inline struct random_path random_path(uint32_t seed, uint32_t pixel, uint32_t sample)
{
    return (struct random_path){random_mix(((uint64_t)seed << 32 | pixel) + 0x9e3779b97f4a7c15ull),
                                random_reverse(sample)};
}

/* Another path with the same pixel and sample. */
static inline struct random_path random_branch(struct random_path path, uint32_t branch)
{
    return (struct random_path){random_mix(path.key ^ (uint64_t)branch << 40), path.reversed_sample};
}

/* Uniform in [0, 1), 24 bits. */
static inline float random_at(struct random_path path, uint32_t dimension)
{
    uint64_t pair = random_mix(path.key + 0x9e3779b97f4a7c15ull * (dimension / 2 + 1));
    uint32_t index = random_reverse(random_permute(path.reversed_sample, (uint32_t)pair));
    uint32_t scramble = (uint32_t)(pair >> 32);
    uint32_t point = dimension & 1 ? random_permute(random_pascal(index), scramble * 0x9e3779b9u + 0x7f4a7c15u)
                                   : random_permute(index, scramble);
    return (float)(random_reverse(point) >> 8) * 0x1p-24f;
}

#endif
