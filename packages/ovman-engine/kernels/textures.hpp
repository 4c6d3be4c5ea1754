// Procedural textures, evaluated at the point that a pixel shows.
#pragma once

#include "geometry.hpp"

namespace ovman {

// In the order of textures.KINDS.
enum class Texture : int32_t {
    plain, wood, fabric, weave, tiles, marble, metal, print, picture, leaves, pages, cardboard,
    checker, stripes, screen, outdoors, text, label, speckle,
};

struct Material {
    Vec colour;       // linear RGB
    Texture texture;
    float scale;      // period of the texture, metres
    int32_t seed;
    float gloss;      // 0 dull to 1 mirror-like
    float emission;   // 0 to 1
    int32_t clear;    // 1: glass
    Vec other{};      // second colour of a pattern
    float shift_u = 0, shift_v = 0;  // place of the texture in the noise, metres

    // Computes the last three from the others.
    void prepare();
};

// A point on a face: coordinates from its middle and half extents of the face, metres, and the width of a pixel there, metres.
struct Spot {
    float u, v, half_u, half_v, footprint;
};

constexpr int TILE = 256;       // width of a noise table; a power of two
enum Noise { CLOUDS, GRAIN, VEINS, THREAD };

// Linear RGB of a material at a spot. `noise`: (4, TILE, TILE) as of textures.noise(). Detail finer than the footprint fades to its
// mean instead of flickering.
Vec texel(const Material& material, Spot at, const float* noise);

}  // namespace ovman
