#include "raster.hpp"

#include <algorithm>

namespace ovman {
namespace {

constexpr int SHIFT = 12;
constexpr int64_t SUBPIXEL = 1 << SHIFT;   // steps of a vertex within a pixel
constexpr double LIMIT = double(1 << 29);  // largest coordinate of a vertex, steps
constexpr float COPLANAR = 2e-6f;          // relative difference of nearness below which triangles count as coplanar
constexpr int SMALL = 8;                   // width of a box in pixels up to which every pixel is tested

struct Point {
    int64_t x, y;  // steps
};

Point on_screen(const Projection& onto, Vecd p) {
    const double scale = onto.perspective ? 1.0 / p.z : 1.0;
    const double x = (0.5 + 0.5 * p.x * scale) * onto.width * SUBPIXEL, y = (0.5 - 0.5 * p.y * scale) * onto.height * SUBPIXEL;
    return {int64_t(std::floor(std::clamp(x, -LIMIT, LIMIT) + 0.5)), int64_t(std::floor(std::clamp(y, -LIMIT, LIMIT) + 0.5))};
}

// The nearness of a triangle's plane at pixel centres: base + x * right + y * down.
struct Plane {
    double base, right, down;
};

bool plane_of(const Projection& onto, Vecd a, Vecd b, Vecd c, Plane& plane) {
    const Vecd n = cross(b - a, c - a);
    const double d = dot(n, a), inverse = 1.0 / (onto.perspective ? d : n.z);
    if (!std::isfinite(inverse)) return false;
    // at the pixel centre (x, y) the ray is ((2 x + 1) / width - 1, 1 - (2 y + 1) / height, 1)
    const double across = 2.0 / onto.width, along = -2.0 / onto.height;
    const double x0 = 1.0 / onto.width - 1.0, y0 = 1.0 - 1.0 / onto.height;
    if (onto.perspective) {
        plane = {(n.x * x0 + n.y * y0 + n.z) * inverse, n.x * across * inverse, n.y * along * inverse};
    } else {
        plane = {(n.x * x0 + n.y * y0 - d) * inverse, n.x * across * inverse, n.y * along * inverse};
    }
    return true;
}

void draw(Point a, Point b, Point c, const Plane& plane, float least, float most, int number, Canvas& canvas) {
    const int64_t area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (area == 0) return;
    if (area < 0) std::swap(b, c);
    const int64_t half = SUBPIXEL / 2;
    const int left = int(std::max<int64_t>(0, (std::min({a.x, b.x, c.x}) + half - 1) >> SHIFT));
    const int right = int(std::min<int64_t>(canvas.width - 1, (std::max({a.x, b.x, c.x}) - half) >> SHIFT));
    const int top = int(std::max<int64_t>(0, (std::min({a.y, b.y, c.y}) + half - 1) >> SHIFT));
    const int bottom = int(std::min<int64_t>(canvas.height - 1, (std::max({a.y, b.y, c.y}) - half) >> SHIFT));
    if (left > right || top > bottom) return;
    // an edge function is not negative inside: it grows by `step` from pixel to pixel and by `fall` from row to row
    const Point from[3] = {a, b, c}, to[3] = {b, c, a};
    int64_t start[3], step[3], fall[3];
    for (int k = 0; k < 3; ++k) {
        const int64_t dx = to[k].x - from[k].x, dy = to[k].y - from[k].y;
        step[k] = -dy * SUBPIXEL;
        fall[k] = dx * SUBPIXEL;
        start[k] = dx * (top * SUBPIXEL + half - from[k].y) - dy * (left * SUBPIXEL + half - from[k].x);
    }
    for (int y = top; y <= bottom; ++y) {
        int first = left, last = right;
        if (right - left >= SMALL) {
            for (int k = 0; k < 3; ++k) {
                if (step[k] > 0) {
                    if (start[k] < 0) first = std::max<int64_t>(first, left + (-start[k] + step[k] - 1) / step[k]);
                } else if (start[k] < 0) {
                    last = -1;
                } else if (step[k] < 0) {
                    last = std::min<int64_t>(last, left + start[k] / -step[k]);
                }
            }
        }
        const bool test = right - left < SMALL;
        int64_t e0 = start[0], e1 = start[1], e2 = start[2];
        const double row = plane.base + y * plane.down;
        float* nearness = canvas.nearness.data() + size_t(y) * canvas.width;
        int32_t* triangle = canvas.triangle.data() + size_t(y) * canvas.width;
        for (int x = first; x <= last; ++x) {
            const bool inside = !test || (e0 | e1 | e2) >= 0;
            if (test) e0 += step[0], e1 += step[1], e2 += step[2];
            if (!inside) continue;
            const float nearer = float(row + x * plane.right), had = nearness[x];
            if (nearer > had + std::fabs(had) * COPLANAR && nearer >= least && nearer <= most) {
                nearness[x] = nearer;
                triangle[x] = number;
            }
        }
        for (int k = 0; k < 3; ++k) start[k] += fall[k];
    }
}

// Whether a box may be visible: not all its corners are on the outer side of one plane of the view.
bool in_view(const Projection& onto, const Bounds& box) {
    bool out[5] = {true, true, true, true, true};
    for (int corner = 0; corner < 8; ++corner) {
        const Vecd p{corner & 1 ? box.high.x : box.low.x, corner & 2 ? box.high.y : box.low.y,
                     corner & 4 ? box.high.z : box.low.z};
        const double x = dot(onto.right, p) + onto.at_right, y = dot(onto.up, p) + onto.at_up;
        const double z = dot(onto.forward, p) + onto.at_forward, reach = onto.perspective ? z : 1.0;
        out[0] &= z < onto.near;
        out[1] &= x > reach;
        out[2] &= x < -reach;
        out[3] &= y > reach;
        out[4] &= y < -reach;
    }
    return !(out[0] || out[1] || out[2] || out[3] || out[4]);
}

}  // namespace

Projection Projection::of(const Camera& camera) {
    Projection onto;
    const double wide = 1.0 / double(camera.tan_x), high = 1.0 / double(camera.tan_y);
    onto.right = Vecd(camera.right) * wide;
    onto.up = Vecd(camera.up) * high;
    onto.forward = Vecd(camera.forward);
    const Vecd eye(camera.eye);
    onto.at_right = -dot(onto.right, eye);
    onto.at_up = -dot(onto.up, eye);
    onto.at_forward = -dot(onto.forward, eye);
    onto.perspective = !camera.flat;
    onto.near = camera.near;
    onto.far = camera.far;
    onto.width = camera.width;
    onto.height = camera.height;
    return onto;
}

Canvas::Canvas(int width, int height)
    : width(width), height(height), nearness(size_t(width) * height, -1e30f), triangle(size_t(width) * height, -1) {}

void rasterise(const Mesh& mesh, const std::vector<Run>& runs, const uint8_t* hidden, int offset, const Projection& onto,
               Canvas& canvas) {
    const float least = float(onto.perspective ? 1.0 / onto.far : -onto.far);
    const float most = float(onto.perspective ? 1.0 / onto.near : -onto.near);
    std::vector<Vecd> placed;
    std::vector<Point> points;
    for (const Run& run : runs) {
        if (!in_view(onto, run.box)) continue;
        const int base = run.first_vertex;
        placed.resize(run.end_vertex - base);
        points.resize(placed.size());
        for (int v = base; v < run.end_vertex; ++v) {
            const Vecd p(mesh.vertex(v));
            Vecd& q = placed[v - base];
            q = {dot(onto.right, p) + onto.at_right, dot(onto.up, p) + onto.at_up, dot(onto.forward, p) + onto.at_forward};
            if (q.z >= onto.near) points[v - base] = on_screen(onto, q);
        }
        for (int t = run.first; t < run.end; ++t) {
            if (hidden && hidden[t]) continue;
            const int* corner = mesh.triangles + 3 * t;
            const Vecd p[3] = {placed[corner[0] - base], placed[corner[1] - base], placed[corner[2] - base]};
            int beyond = 0;
            for (const Vecd& q : p) beyond += q.z >= onto.near;
            Plane plane;
            if (beyond == 0) continue;
            if (beyond == 3) {
                const Point a = points[corner[0] - base], b = points[corner[1] - base], c = points[corner[2] - base];
                // most triangles are smaller than a pixel: those that cover no centre end here
                const int64_t half = SUBPIXEL / 2;
                const int64_t low_x = std::min({a.x, b.x, c.x}), high_x = std::max({a.x, b.x, c.x});
                if ((low_x + half - 1) >> SHIFT > (high_x - half) >> SHIFT) continue;
                const int64_t low_y = std::min({a.y, b.y, c.y}), high_y = std::max({a.y, b.y, c.y});
                if ((low_y + half - 1) >> SHIFT > (high_y - half) >> SHIFT) continue;
                if (!plane_of(onto, p[0], p[1], p[2], plane)) continue;
                draw(a, b, c, plane, least, most, offset + t, canvas);
                continue;
            }
            // cut off what is nearer than the near plane; an edge is cut at the same point from both its triangles
            if (!plane_of(onto, p[0], p[1], p[2], plane)) continue;
            Point kept[4];
            int count = 0;
            for (int k = 0; k < 3; ++k) {
                Vecd q = p[k], r = p[(k + 1) % 3];
                if (q.z >= onto.near) kept[count++] = on_screen(onto, q);
                if ((q.z >= onto.near) == (r.z >= onto.near)) continue;
                if (q.z > r.z) std::swap(q, r);
                const double share = (onto.near - q.z) / (r.z - q.z);
                kept[count++] = on_screen(onto, {q.x + share * (r.x - q.x), q.y + share * (r.y - q.y), onto.near});
            }
            for (int k = 1; k + 1 < count; ++k) draw(kept[0], kept[k], kept[k + 1], plane, least, most, offset + t, canvas);
        }
    }
}

std::vector<Run> runs_of(const Mesh& mesh) {
    std::vector<Run> runs;
    for (int t = 0; t < mesh.count; ++t) {
        if (t == 0 || mesh.part[t] != mesh.part[t - 1]) runs.push_back({t, t, INT32_MAX, 0, {}});
        Run& run = runs.back();
        run.end = t + 1;
        for (int k = 0; k < 3; ++k) {
            const int v = mesh.triangles[3 * t + k];
            run.first_vertex = std::min(run.first_vertex, v);
            run.end_vertex = std::max(run.end_vertex, v + 1);
            run.box.add(mesh.vertex(v));
        }
    }
    return runs;
}

}  // namespace ovman
