// Draws a view of a scene: depth, instance ids, normals and colours.
#pragma once

#include <memory>
#include <vector>

#include "light.hpp"
#include "textures.hpp"

namespace ovman {

// A scene as a camera sees it: the solids of its light, and a third one without shadows (the agent's body).
struct Scene {
    std::shared_ptr<Field> field;
    std::shared_ptr<const Solid> extra;
    std::vector<uint8_t> hidden;  // (T,) of the fixed solid, or empty
    std::vector<Material> materials;
    const float* noise;           // textures.noise()
    const float* curve;           // film.curve()
};

// Images of H x W pixels, row by row; null where not wanted.
struct Images {
    int32_t* ids;    // -1 without a hit
    float* depth;    // metres; the far plane without a hit
    float* normals;  // (H W, 3) towards the viewer; 0 without a hit
    uint8_t* rgb;    // (H W, 3) sRGB
    const uint8_t* sky;  // (3,) sRGB without a hit, or null for the default sky
};

void draw(const Scene& scene, const Camera& camera, const Images& images);

constexpr int CURVE = 4096;       // entries of the film curve
constexpr float BRIGHTEST = 4.0f; // linear light of its last entry

}  // namespace ovman
