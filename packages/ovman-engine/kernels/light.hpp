// Light on the surfaces of a scene, computed at points a few centimetres apart where and when a picture first needs them.
#pragma once

#include <memory>
#include <vector>

#include "geometry.hpp"
#include "raster.hpp"
#include "tree.hpp"

namespace ovman {

struct Lamp {
    Vec position, colour, axis;  // axis: of the emission, which falls off as the cosine; 0 for a lamp in all directions
    float softening;             // added to the squared distance, square metres
    bool aimed;
};

// A point on a lamp from which shadows fall.
struct Sample {
    Vec point;
    float clearance;  // objects nearer than this to the lamp cast no shadow, metres
    int lamp;
    float share;      // of the lamp's light
};

// An opening of a window: the plane `axis` = `plane`, from low to high along the other horizontal axis, and in height.
struct Pane {
    int axis;
    float plane, low, high, bottom, top;
    float per_depth;  // one over the sun's way along `axis`
};

constexpr int MOST_LAMPS = 64;

// lights.Rig. The first `shadowed` lamps cast shadows.
struct Rig {
    std::vector<Lamp> lamps;
    int shadowed = 0;
    std::vector<Sample> samples;
    Vec above, beside, below;  // ambient light by the direction that a surface faces
    float exposure = 1;
    bool sunny = false;
    Vec sun_way, sun_colour;
    std::vector<Pane> panes;
};

// Light that arrives at a point: its colour, its mean direction, scaled to length 1 along the normal of the point, and the fraction
// of free surroundings, negative before it is known.
struct Glow {
    Vec light, way;
    float open = -1;
};

inline Glow mix(const Glow& a, const Glow& b, float share) {
    return {mix(a.light, b.light, share), mix(a.way, b.way, share), a.open + (b.open - a.open) * share};
}

// Light of lamps without shadows.
Glow direct(const Rig& rig, Vec point, Vec normal);

// The triangles of one part that face along one axis of it, in one direction: a rectangle of nodes in the two other coordinates.
struct Chart {
    int part, axis, u_axis, v_axis;
    bool positive;
    float u0, v0, du, dv;
    float per_u, per_v;  // nodes per metre
    int columns, rows;
    int node;        // number of its first node in its solid
    int first, end;  // triangles in Charts::triangles
    Bounds box;
};

struct Charts {
    explicit Charts(const Mesh& mesh);
    std::vector<int32_t> of_triangle;
    std::vector<Chart> charts;
    std::vector<int32_t> triangles;
    int node_count = 0;
};

// A mesh with what is computed from it once.
struct Solid {
    Mesh mesh;
    std::vector<Run> runs;
    Tree tree;
    Charts charts;
    std::vector<uint8_t> flat;  // triangles whose normal is the same all over

    explicit Solid(const Mesh& mesh);
};

// A region in which something changed.
struct Ball {
    Vec centre;
    float radius;
};

// The light of one state of a scene: a fixed solid without its `hidden` triangles, and a moved one.
class Field {
  public:
    // `before`: the light of the whole fixed solid under the same rig, from which all is taken that the `changes` do not reach.
    // Null for that light itself.
    Field(std::shared_ptr<const Solid> fixed, std::vector<uint8_t> hidden, std::shared_ptr<const Solid> moved, Rig rig,
          std::shared_ptr<Field> before, std::vector<Ball> changes);

    const Rig& rig() const { return rig_; }
    const Solid& fixed() const { return *fixed_; }
    const Solid& moved() const { return *moved_; }

    // Light at a point on a triangle of the fixed or moved solid, seen from the side that it winds to.
    Glow at(bool moved, int triangle, Vec point);

    // Fraction of the sun's light at a point, 0 to 1.
    float sunlight(Vec point, Vec normal) {
        if (!rig_.sunny || dot(normal, rig_.sun_way) <= 0.02f) return 0;
        return through_panes(point + normal * LIFT_M);
    }

    static constexpr float LIFT_M = 0.004f;  // rays start this far above a surface

  private:
    void fill(bool moved, int chart, int number);
    Glow compute(Vec point, Vec normal, float least) const;
    bool reaches(Vec point, float radius) const;
    bool blocked(Vec origin, Vec way, float reach) const;
    float through_panes(Vec point);
    void open_panes();

    std::shared_ptr<const Solid> fixed_, moved_;
    std::vector<uint8_t> hidden_;
    Rig rig_;
    std::shared_ptr<Field> before_;
    std::vector<Ball> changes_;
    std::vector<Glow> own_[2];       // nodes of the fixed solid's charts that the changes reach, and of the moved one's
    std::vector<Glow*> charts_[2];   // first node of each chart, of this field or of `before_`
    std::vector<uint8_t> shared_;    // charts of the fixed solid whose light is that of `before_`
    std::vector<Canvas> shade_;      // what the sun meets behind each pane
    bool opened_ = false;
};

}  // namespace ovman
