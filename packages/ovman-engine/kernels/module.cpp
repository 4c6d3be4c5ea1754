// The Python module ovman_engine.kernels.
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <stdexcept>

#include "corners.hpp"
#include "paint.hpp"

namespace py = pybind11;
using namespace ovman;
using namespace pybind11::literals;

namespace {

template <typename T> using Array = py::array_t<T, py::array::c_style | py::array::forcecast>;
using Floats = Array<float>;
using Integers = Array<int32_t>;

Vec vec(const Floats& a, py::ssize_t row = 0) {
    const float* p = a.data() + 3 * row;
    return {p[0], p[1], p[2]};
}

// A solid with the arrays that it reads.
struct Held {
    py::tuple arrays;
    std::shared_ptr<const Solid> solid;
};

Held held(Floats vertices, Integers triangles, Floats normals, Integers instance, Integers material, Integers part, Integers axis,
          Floats frames, Floats extents) {
    Mesh mesh{vertices.data(), triangles.data(), normals.data(), instance.data(), material.data(),
              part.data(),     axis.data(),      frames.data(),  extents.data(),  int(vertices.shape(0)),
              int(triangles.shape(0)), int(frames.shape(0))};
    for (int i = 0; i < 3 * mesh.count; ++i)
        if (mesh.triangles[i] < 0 || mesh.triangles[i] >= mesh.vertex_count) throw std::invalid_argument("a triangle names no vertex");
    py::tuple arrays = py::make_tuple(vertices, triangles, normals, instance, material, part, axis, frames, extents);
    return {arrays, std::make_shared<const Solid>(mesh)};
}

std::vector<uint8_t> mask(const Array<bool>& hidden, const Solid& of) {
    if (hidden.size() == 0) return {};
    if (hidden.size() != of.mesh.count) throw std::invalid_argument("a mask has one entry for each triangle");
    return {hidden.data(), hidden.data() + hidden.size()};
}

// First hits of rays (N, 3) in several solids, whose triangles are numbered one after the other.
py::tuple closest(const std::vector<const Held*>& solids, const Floats& origins, const Floats& ways) {
    const py::ssize_t count = origins.shape(0);
    Integers triangle(count);
    Floats distance(count), u(count), v(count);
    for (py::ssize_t i = 0; i < count; ++i) {
        Hit best{-1, 1e30f, 0, 0};
        int offset = 0;
        for (const Held* h : solids) {
            Hit hit{-1, best.distance, 0, 0};
            if (h->solid->tree.closest(vec(origins, i), vec(ways, i), nullptr, hit)) {
                best = hit;
                best.triangle += offset;
            }
            offset += h->solid->mesh.count;
        }
        triangle.mutable_at(i) = best.triangle, distance.mutable_at(i) = best.distance;
        u.mutable_at(i) = best.u, v.mutable_at(i) = best.v;
    }
    return py::make_tuple(triangle, distance, u, v);
}

Rig rig(const Floats& lamps, int shadowed, const Floats& samples, const Floats& ambient, float exposure, const Floats& sun,
        const Floats& panes) {
    Rig made;
    for (py::ssize_t i = 0; i < lamps.shape(0); ++i) {
        const float* p = lamps.data(i, 0);
        made.lamps.push_back({{p[0], p[1], p[2]}, {p[3], p[4], p[5]}, {p[6], p[7], p[8]}, p[9], p[10] > 0});
    }
    if (made.lamps.size() > MOST_LAMPS) throw std::invalid_argument("at most 64 lamps");
    made.shadowed = shadowed;
    for (py::ssize_t i = 0; i < samples.shape(0); ++i) {
        const float* p = samples.data(i, 0);
        if (int(p[4]) < 0 || int(p[4]) >= int(made.lamps.size())) throw std::invalid_argument("a sample names no lamp");
        made.samples.push_back({{p[0], p[1], p[2]}, p[3], int(p[4]), p[5]});
    }
    made.above = vec(ambient, 0), made.beside = vec(ambient, 1), made.below = vec(ambient, 2);
    made.exposure = exposure;
    if (sun.size()) {
        made.sunny = true;
        made.sun_way = vec(sun, 0), made.sun_colour = vec(sun, 1);
        for (py::ssize_t i = 0; i < panes.shape(0); ++i) {
            const float* p = panes.data(i, 0);
            made.panes.push_back({int(p[0]), p[1], p[2], p[3], p[4], p[5], 1 / made.sun_way[int(p[0])]});
        }
    }
    return made;
}

// A field with the solids that it reads.
struct HeldField {
    py::tuple keeps;
    std::shared_ptr<Field> field;
};

HeldField field(const Held& fixed, const Array<bool>& hidden, const Held& moved, const Rig& rig, const py::object& before,
                const Floats& changes) {
    std::vector<Ball> balls;
    for (py::ssize_t i = 0; i < changes.shape(0); ++i) balls.push_back({{changes.at(i, 0), changes.at(i, 1), changes.at(i, 2)}, changes.at(i, 3)});
    std::shared_ptr<Field> parent = before.is_none() ? nullptr : before.cast<const HeldField&>().field;
    return {py::make_tuple(fixed.arrays, moved.arrays, before),
            std::make_shared<Field>(fixed.solid, mask(hidden, *fixed.solid), moved.solid, rig, parent, balls)};
}

std::vector<Material> materials(const Floats& colours, const Integers& kinds, const Floats& scales, const Integers& seeds,
                                const Floats& glosses, const Floats& emissions, const Array<bool>& clear) {
    std::vector<Material> made;
    for (py::ssize_t i = 0; i < colours.shape(0); ++i) {
        made.push_back({vec(colours, i), Texture(kinds.at(i)), scales.at(i), seeds.at(i), glosses.at(i), emissions.at(i), clear.at(i)});
        made.back().prepare();
    }
    return made;
}

struct Materials {
    std::vector<Material> all;
};

Camera camera(const Floats& eye, const Floats& axes, float tan_x, float tan_y, float near, float far, int width, int height, bool flat) {
    return {vec(eye), vec(axes, 0), vec(axes, 1), vec(axes, 2), tan_x, tan_y, near, far, width, height, flat};
}

py::dict drawn(const HeldField& field, const Array<bool>& hidden, const Held& extra, const Materials& materials, const Floats& noise,
               const Floats& curve, const Camera& camera, const py::object& sky, bool rgb, bool normals) {
    const auto side = std::vector<py::ssize_t>{camera.height, camera.width};
    const auto deep = std::vector<py::ssize_t>{camera.height, camera.width, 3};
    Integers ids(side);
    Floats depth(side);
    py::object facing = py::none(), picture = py::none();
    Images images{ids.mutable_data(), depth.mutable_data(), nullptr, nullptr, nullptr};
    if (normals) {
        Floats made(deep);
        images.normals = made.mutable_data();
        facing = made;
    }
    if (rgb) {
        py::array_t<uint8_t> made(deep);
        images.rgb = made.mutable_data();
        picture = made;
    }
    Array<uint8_t> colour;
    if (!sky.is_none()) {
        colour = sky.cast<Array<uint8_t>>();
        images.sky = colour.data();
    }
    const Scene scene{field.field, extra.solid, mask(hidden, field.field->fixed()), materials.all, noise.data(), curve.data()};
    for (const Solid* solid : {&field.field->fixed(), &field.field->moved(), extra.solid.get()})
        for (int t = 0; t < solid->mesh.count; ++t)
            if (solid->mesh.material[t] < 0 || solid->mesh.material[t] >= int(scene.materials.size()))
                throw std::invalid_argument("a triangle names no material");
    draw(scene, camera, images);
    return py::dict("ids"_a = ids, "depth"_a = depth, "normals"_a = facing, "rgb"_a = picture);
}

py::tuple corner_normals_of(const Array<double>& vertices, const Integers& triangles, const Integers& part, const Array<double>& turns,
                            double cosine) {
    const py::ssize_t count = triangles.shape(0);
    Array<double> normals(std::vector<py::ssize_t>{count, 3, 3});
    Integers axis(count);
    corner_normals(vertices.data(), int(vertices.shape(0)), triangles.data(), part.data(), int(count), turns.data(), cosine,
                   normals.mutable_data(), axis.mutable_data());
    return py::make_tuple(normals, axis);
}

}  // namespace

PYBIND11_MODULE(kernels, module) {
    module.doc() = "Draws scenes of triangles and casts rays through them; written in C++ (kernels/).";
    py::class_<Held>(module, "Solid", "The triangles of a mesh, ready to be drawn and met by rays.")
        .def(py::init(&held), "vertices"_a, "triangles"_a, "normals"_a, "instance"_a, "material"_a, "part"_a, "axis"_a, "frames"_a,
             "extents"_a)
        .def("__len__", [](const Held& h) { return h.solid->mesh.count; });
    py::class_<Rig>(module, "Rig", "The lights of a scene; see lights.Rig.")
        .def(py::init(&rig), "lamps"_a, "shadowed"_a, "samples"_a, "ambient"_a, "exposure"_a, "sun"_a, "panes"_a);
    py::class_<HeldField>(module, "Field", "Light on the surfaces of a fixed and a moved solid.")
        .def(py::init(&field), "fixed"_a, "hidden"_a, "moved"_a, "rig"_a, "before"_a, "changes"_a);
    py::class_<Materials>(module, "Materials", "Materials by number; see painter.Appearance.")
        .def(py::init([](const Floats& colours, const Integers& kinds, const Floats& scales, const Integers& seeds, const Floats& glosses,
                         const Floats& emissions, const Array<bool>& clear) {
                 return Materials{materials(colours, kinds, scales, seeds, glosses, emissions, clear)};
             }),
             "colours"_a, "kinds"_a, "scales"_a, "seeds"_a, "glosses"_a, "emissions"_a, "clear"_a);
    py::class_<Camera>(module, "Camera", "A camera.View as the kernels see it.")
        .def(py::init(&camera), "eye"_a, "axes"_a, "tan_x"_a, "tan_y"_a, "near"_a, "far"_a, "width"_a, "height"_a, "flat"_a);
    module.def("draw", &drawn, "field"_a, "hidden"_a, "extra"_a, "materials"_a, "noise"_a, "curve"_a, "camera"_a, "sky"_a, "rgb"_a,
               "normals"_a, "Draw a view: arrays ids, depth, and where wanted normals and rgb.");
    module.def("closest", [](const py::list& solids, const Floats& origins, const Floats& ways) {
        std::vector<const Held*> all;
        for (const auto& s : solids) all.push_back(&s.cast<const Held&>());
        return closest(all, origins, ways);
    }, "solids"_a, "origins"_a, "ways"_a,
               "Find the first hit of each ray (N, 3): triangle, distance in lengths of the way, and two barycentric coordinates (N,).");
    module.def("corner_normals", &corner_normals_of, "vertices"_a, "triangles"_a, "part"_a, "turns"_a, "cosine"_a,
               "Compute normals (T, 3, 3) at corners, and the axes (T,) that triangles face; see corners.of_parts.");
}
