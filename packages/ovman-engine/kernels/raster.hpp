// Finds the nearest triangle at every pixel centre.
#pragma once

#include <vector>

#include "geometry.hpp"

namespace ovman {

// A linear map of world points to (x, y, depth), and of those to pixels: x and y are in halves of the image, divided by the depth
// in a perspective map.
struct Projection {
    Vecd right, up, forward;
    double at_right, at_up, at_forward;  // added to the products
    bool perspective;
    double near, far;
    int width, height;

    static Projection of(const Camera& camera);
};

// Nearness of the nearest triangle at each pixel, and its number; -1 for none.
struct Canvas {
    int width, height;
    std::vector<float> nearness;  // 1 / depth, or -depth in a parallel map
    std::vector<int32_t> triangle;

    Canvas(int width, int height);
};

// Draws the triangles of a mesh that are not `hidden` (T,) or null, numbered from `offset`. Of coplanar triangles, the first stays.
void rasterise(const Mesh& mesh, const std::vector<Run>& runs, const uint8_t* hidden, int offset, const Projection& onto,
               Canvas& canvas);

}  // namespace ovman
