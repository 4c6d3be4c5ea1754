// Casts single rays: a bounding volume hierarchy over the triangles of a mesh.
#pragma once

#include <vector>

#include "geometry.hpp"

namespace ovman {

class Tree {
  public:
    explicit Tree(const Mesh& mesh);

    // Lowers `best` to the first hit of a ray that is nearer, of triangles that are not `hidden` (T,) or null; of triangles at one
    // distance, the first in number. Returns whether there was one.
    bool closest(Vec origin, Vec way, const uint8_t* hidden, Hit& best) const;

    // Whether a ray meets a triangle before `reach` lengths of it.
    bool blocked(Vec origin, Vec way, float reach, const uint8_t* hidden) const;

  private:
    struct Node {
        Bounds box;
        int32_t first, count;  // triangles of a leaf; without triangles, `first` is the left child, followed by the right one
    };
    void split(int node, int first, int end, int depth, const std::vector<Bounds>& boxes, std::vector<int32_t>& order);
    template <bool any> bool search(Vec origin, Vec way, const uint8_t* hidden, Hit& best) const;

    struct Corners {
        Vec a, b, c;
        int32_t number;
    };
    std::vector<Node> nodes_;
    std::vector<Corners> triangles_;  // leaf by leaf
};

}  // namespace ovman
