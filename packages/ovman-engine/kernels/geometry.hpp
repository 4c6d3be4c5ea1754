// Vectors, meshes and cameras, as the kernels see them.
//
// World frame: Unity's, left-handed, y up, metres. All arithmetic is IEEE without contraction or reordering (setup.py), so equal
// inputs give equal bytes on every processor.
#pragma once

#include <cmath>
#include <cstdint>
#include <vector>

namespace ovman {

// Without the rules for NaN of std::fmax and std::fmin, which cost a call.
inline float larger(float a, float b) { return a > b ? a : b; }
inline float smaller(float a, float b) { return a < b ? a : b; }

struct Vec {
    float x = 0, y = 0, z = 0;
    float operator[](int axis) const { return axis == 0 ? x : axis == 1 ? y : z; }
};

inline Vec operator+(Vec a, Vec b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vec operator-(Vec a, Vec b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vec operator-(Vec a) { return {-a.x, -a.y, -a.z}; }
inline Vec operator*(Vec a, float k) { return {a.x * k, a.y * k, a.z * k}; }
inline Vec operator*(Vec a, Vec b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
inline Vec& operator+=(Vec& a, Vec b) { return a = a + b; }
inline float dot(Vec a, Vec b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline float length(Vec a) { return std::sqrt(dot(a, a)); }
inline float sum(Vec a) { return a.x + a.y + a.z; }
inline Vec mix(Vec a, Vec b, float share) { return a + (b - a) * share; }
inline float clamp(float x, float low, float high) { return x < low ? low : x > high ? high : x; }
inline Vec unit(Vec a) { return a * (1.0f / std::sqrt(larger(dot(a, a), 1e-12f))); }

struct Vecd {
    double x = 0, y = 0, z = 0;
    Vecd() = default;
    Vecd(double x, double y, double z) : x(x), y(y), z(z) {}
    explicit Vecd(Vec v) : x(v.x), y(v.y), z(v.z) {}
};

inline Vecd operator+(Vecd a, Vecd b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
inline Vecd operator-(Vecd a, Vecd b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
inline Vecd operator*(Vecd a, double k) { return {a.x * k, a.y * k, a.z * k}; }
inline double dot(Vecd a, Vecd b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Vecd cross(Vecd a, Vecd b) { return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x}; }
inline Vec narrow(Vecd a) { return {float(a.x), float(a.y), float(a.z)}; }

// An axis-aligned box.
struct Bounds {
    Vec low{1e30f, 1e30f, 1e30f}, high{-1e30f, -1e30f, -1e30f};
    void add(Vec p) {
        low = {smaller(low.x, p.x), smaller(low.y, p.y), smaller(low.z, p.z)};
        high = {larger(high.x, p.x), larger(high.y, p.y), larger(high.z, p.z)};
    }
    void add(const Bounds& b) {
        add(b.low);
        add(b.high);
    }
    Vec middle() const { return (low + high) * 0.5f; }
    float radius() const { return 0.5f * length(high - low); }
};

// The columns of a triangle_mesh.TriangleMesh with V vertices, T triangles and P parts; the arrays belong to Python.
struct Mesh {
    const float* vertices;         // (V, 3)
    const int32_t* triangles;      // (T, 3)
    const float* normals;          // (T, 3, 3)
    const int32_t* instance;       // (T,)
    const int32_t* material;       // (T,)
    const int32_t* part;           // (T,)
    const int32_t* axis;           // (T,)
    const float* frames;           // (P, 3, 4)
    const float* extents;          // (P, 3)
    int vertex_count = 0, count = 0, part_count = 0;

    Vec vertex(int v) const { return {vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]}; }
    Vec corner(int t, int k) const { return vertex(triangles[3 * t + k]); }
    Vec normal(int t, int k) const {
        const float* n = normals + 9 * t + 3 * k;
        return {n[0], n[1], n[2]};
    }
    // The coordinate `axis` of a world point in the frame of a part, metres.
    float local(int part, int axis, Vec p) const {
        const float* row = frames + 12 * part + 4 * axis;
        return row[0] * p.x + row[1] * p.y + row[2] * p.z + row[3];
    }
    Vec row(int part, int axis) const {
        const float* r = frames + 12 * part + 4 * axis;
        return {r[0], r[1], r[2]};
    }
};

// A run of consecutive triangles of one part, and the run of its vertices.
struct Run {
    int first, end, first_vertex, end_vertex;
    Bounds box;
};

std::vector<Run> runs_of(const Mesh& mesh);

// A point of a triangle: barycentric coordinates of the second and third corner, and the distance in lengths of the ray.
struct Hit {
    int triangle = -1;
    float distance = 0, u = 0, v = 0;
};

// Where a ray meets a triangle (Moeller and Trumbore 1997), in double precision. NaN distance where it misses.
struct Meeting {
    double distance, u, v;
};

inline Meeting meet(Vec corner, Vec second, Vec third, Vecd origin, Vecd way) {
    const Vecd a(corner), e = Vecd(second) - a, f = Vecd(third) - a, s = origin - a;
    const Vecd p = cross(way, f);
    const double area = dot(e, p), u = dot(s, p);
    // most triangles are missed: they are told without a division
    if (area > 0 ? u < 0 || u > area : u > 0 || u < area) return {std::nan(""), 0, 0};
    const Vecd q = cross(s, e);
    const double v = dot(way, q);
    if (area > 0 ? v < 0 || u + v > area : v > 0 || u + v < area) return {std::nan(""), 0, 0};
    const double inverse = 1.0 / area, distance = dot(f, q) * inverse;
    return {distance > 0 ? distance : std::nan(""), u * inverse, v * inverse};
}

// Where a ray meets the plane of a triangle, by the same coordinates.
inline Meeting meet_plane(const Mesh& mesh, int t, Vecd origin, Vecd way) {
    const Vecd a(mesh.corner(t, 0)), e = Vecd(mesh.corner(t, 1)) - a, f = Vecd(mesh.corner(t, 2)) - a, s = origin - a;
    const Vecd p = cross(way, f), q = cross(s, e);
    const double inverse = 1.0 / dot(e, p);
    return {dot(f, q) * inverse, dot(s, p) * inverse, dot(way, q) * inverse};
}

// A camera.View. The image has row 0 at the top, and pixel centres at +0.5.
struct Camera {
    Vec eye, right, up, forward;
    float tan_x, tan_y;  // half the image at a distance of one metre; orthographic: half the image, metres
    float near, far;
    int width, height;
    bool flat;           // orthographic

    float across(float column) const { return (2.0f * column / float(width) - 1.0f) * tan_x; }
    float upwards(float row) const { return (1.0f - 2.0f * row / float(height)) * tan_y; }
    // The ray through an image point. Its length along `forward` is 1, so distances along it are depths.
    Vec way(float column, float row) const {
        return flat ? forward : right * across(column) + up * upwards(row) + forward;
    }
    Vec origin(float column, float row) const {
        return flat ? eye + right * across(column) + up * upwards(row) : eye;
    }
};

}  // namespace ovman
