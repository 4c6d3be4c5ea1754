#include "paint.hpp"

#include <algorithm>
#include <cstring>

namespace ovman {
namespace {

constexpr Vec SKY{0.55f, 0.65f, 0.75f};
constexpr float MIRROR = 0.85f;  // least gloss of a surface that mirrors
constexpr float PANE_M = 0.02f;  // a ray through glass starts this far behind its face
constexpr float LIFT_M = 0.004f; // a reflected ray starts this far above the surface
constexpr int PANES = 2;         // panes of glass, one behind the other, that are seen through
constexpr float OFFSET = 0.4f;   // of the second sample of an edge pixel from its centre, pixels along each axis
constexpr float FAINT = 0.4f;    // squared cosine below which a highlight is invisible
// light is computed at every STRIDE-th pixel of a row and interpolated, unless those are SMOOTH_M apart
constexpr int STRIDE = 4;
constexpr float SMOOTH_M = 0.3f;
// least relative difference of two neighbours at which an edge is smoothed: between instances, and within one
constexpr float BETWEEN = 0.15f, WITHIN = 0.45f;

enum Whose { FIXED, MOVED, EXTRA };

// A triangle as seen from one side: what its points have in common if it is flat.
struct Face {
    Whose whose = FIXED;
    int triangle = -1;  // of its solid; -1 for the sky
    const Mesh* mesh = nullptr;
    const Material* material = nullptr;
    Vec normal;         // towards the viewer
    bool back = false;  // seen from behind
    Vec around;         // ambient light in open surroundings
};

// A visible point.
struct Point {
    Face face;
    Vec at;
    float footprint = 0;  // width of a pixel, metres
};

// What a point makes of its colour: a factor, and light that is added; `near` is the part of direct light that arrives in a corner.
struct Shade {
    Vec factor, shine;
    float near = 1;
};

Shade mix(const Shade& a, const Shade& b, float share) {
    return {ovman::mix(a.factor, b.factor, share), ovman::mix(a.shine, b.shine, share), a.near + (b.near - a.near) * share};
}

class Painter {
  public:
    Painter(const Scene& scene, const Camera& camera);
    void draw(const Images& images);

  private:
    const Solid& solid(Whose whose) const { return whose == FIXED ? fixed_ : whose == MOVED ? moved_ : *scene_.extra; }
    const uint8_t* hidden() const { return scene_.hidden.empty() ? nullptr : scene_.hidden.data(); }
    Whose owner(int number, int& triangle) const;
    Face face(Whose whose, int triangle, Vec normal, Vec way) const;
    Point round_point(Whose whose, int triangle, Vec origin, Vec way, const Meeting& met) const;
    size_t covering(const Canvas& canvas, int x, int y, int dx, int dy) const;
    Point followed(Vec origin, Vec way) const;
    Shade shade(const Point& p, Vec way) const;
    Vec linear(const Point& p, Vec way, int panes) const;
    Vec through(const Point& p, Vec way, int panes, Vec own) const;
    Vec lit(const Point& p, const Shade& shade) const;
    void paint_run(const Canvas& canvas, int y, int first, int end, const Images& images);
    void smooth_edges(const Canvas& canvas, const Images& images);

    const Scene& scene_;
    const Camera& camera_;
    const Rig& rig_;
    const Solid &fixed_, &moved_;
    float pixel_;                 // width of a pixel at one metre; at any distance in an orthographic view
    float glare_;                 // light of a surface with an emission of 1
    std::vector<float> across_;   // Camera::across of the pixels of a row
    bool wanted_ = false;         // normals or colours
    std::vector<Vec> normals_;    // of all pixels
    std::vector<Vec> light_;      // linear RGB of all pixels
};

Painter::Painter(const Scene& scene, const Camera& camera)
    : scene_(scene), camera_(camera), rig_(scene.field->rig()), fixed_(scene.field->fixed()), moved_(scene.field->moved()),
      pixel_(2.0f * camera.tan_y / float(camera.height)), glare_(1.6f / rig_.exposure), across_(camera.width) {
    for (int x = 0; x < camera.width; ++x) across_[x] = camera.across(float(x) + 0.5f);
}

// The solid of a triangle that is numbered through all three.
Whose Painter::owner(int number, int& triangle) const {
    triangle = number;
    if (triangle < fixed_.mesh.count) return FIXED;
    triangle -= fixed_.mesh.count;
    if (triangle < moved_.mesh.count) return MOVED;
    triangle -= moved_.mesh.count;
    return EXTRA;
}

Face Painter::face(Whose whose, int triangle, Vec normal, Vec way) const {
    const Mesh& mesh = solid(whose).mesh;
    const bool back = dot(normal, way) > 0;
    if (back) normal = -normal;
    const float up = 0.5f + 0.5f * normal.y, side = 1.0f - std::fabs(normal.y);
    const Vec around = rig_.above * (up * (1.0f - side)) + rig_.beside * side + rig_.below * ((1.0f - up) * (1.0f - side));
    return {whose, triangle, &mesh, &scene_.materials[mesh.material[triangle]], normal, back, around};
}

Point Painter::round_point(Whose whose, int triangle, Vec origin, Vec way, const Meeting& met) const {
    const Mesh& mesh = solid(whose).mesh;
    const float u = float(met.u), v = float(met.v), distance = float(met.distance);
    const Vec normal = mesh.normal(triangle, 0) * (1.0f - u - v) + mesh.normal(triangle, 1) * u + mesh.normal(triangle, 2) * v;
    const Face seen = face(whose, triangle, unit(normal), way);
    const float far = length(way), grazing = larger(-dot(seen.normal, way) / far, 0.2f);
    return {seen, origin + way * distance, (camera_.flat ? pixel_ : pixel_ * distance * far) / grazing};
}

// The pixel whose triangle covers a point between the centres of a pixel and of its neighbours: the nearest such triangle.
size_t Painter::covering(const Canvas& canvas, int x, int y, int dx, int dy) const {
    const float column = float(x) + 0.5f + OFFSET * float(dx), row = float(y) + 0.5f + OFFSET * float(dy);
    const Vecd origin(camera_.origin(column, row)), way(camera_.way(column, row));
    size_t best = size_t(y) * canvas.width + x;
    double nearest = 1e30, least = 1e30;
    const int places[4][2] = {{x, y}, {x + dx, y}, {x, y + dy}, {x + dx, y + dy}};
    for (const auto& place : places) {
        if (place[0] < 0 || place[0] >= canvas.width || place[1] < 0 || place[1] >= canvas.height) continue;
        const size_t n = size_t(place[1]) * canvas.width + place[0];
        const int number = canvas.triangle[n];
        if (number < 0 || (least < 1e30 && number == canvas.triangle[best])) continue;
        int triangle;
        const Whose whose = owner(number, triangle);
        const Meeting m = meet_plane(solid(whose).mesh, triangle, origin, way);
        if (!(m.distance > 0)) continue;
        const double outside = std::max({-m.u, -m.v, m.u + m.v - 1, 0.0});
        if (outside < least || (outside == least && m.distance < nearest)) {
            least = outside;
            nearest = m.distance;
            best = n;
        }
    }
    return best;
}

// What a ray meets within the scene.
Point Painter::followed(Vec origin, Vec way) const {
    Point found;
    float nearest = 1e30f;
    for (Whose whose : {FIXED, MOVED, EXTRA}) {
        Hit hit{-1, nearest, 0, 0};
        if (!solid(whose).tree.closest(origin, way, whose == FIXED ? hidden() : nullptr, hit)) continue;
        nearest = hit.distance;
        found = round_point(whose, hit.triangle, origin, way, {hit.distance, hit.u, hit.v});
    }
    return found;
}

// What a point makes of its colour, without the sun.
Shade Painter::shade(const Point& p, Vec way) const {
    const Face& face = p.face;
    const Material& material = *face.material;
    Glow glow = face.whose == EXTRA || face.back ? direct(rig_, p.at, face.normal)
                                                 : scene_.field->at(face.whose == MOVED, face.triangle, p.at);
    // the light was computed for the triangle's own direction there
    glow.light = glow.light * clamp(dot(glow.way, face.normal), 0.0f, 1.6f);
    const float open = 0.4f + 0.6f * glow.open, near = 0.55f + 0.45f * open, glare = material.emission * glare_;
    const Vec ambient = face.around * open;
    Shade shade{ambient + glow.light * near + Vec{glare, glare, glare}, {}, near};
    const float gloss = material.gloss - 0.1f;
    if (gloss > 0) {
        const Vec eye = unit(-way);
        // a glossy surface reflects the room's light at grazing angles
        const float rim = 1.0f - larger(dot(eye, face.normal), 0.0f);
        shade.shine = (ambient + glow.light * 0.5f) * (gloss * (0.04f + 0.4f * rim * rim * rim * rim));
        const Vec half = unit(glow.way) + eye;
        const float along = dot(half, face.normal), size = dot(half, half);
        if (along > 0 && along * along > FAINT * size) {
            float s = along / std::sqrt(size);
            s *= s, s *= s, s *= s, s *= s;
            if (gloss > 0.3f) s *= s * s;
            shade.shine += glow.light * (s * gloss * gloss * 1.2f);
        }
    }
    return shade;
}

// Light that a point sends to the eye by itself.
Vec Painter::lit(const Point& p, const Shade& shade) const {
    const Face& face = p.face;
    const Mesh& mesh = *face.mesh;
    Vec colour = face.material->colour, arriving = shade.factor;
    if (face.material->texture != Texture::plain) {
        const int part = mesh.part[face.triangle], axis = mesh.axis[face.triangle], u = axis == 0 ? 2 : 0, v = axis == 1 ? 2 : 1;
        const float* half = mesh.extents + 3 * part;
        colour = texel(*face.material, {mesh.local(part, u, p.at), mesh.local(part, v, p.at), half[u], half[v], p.footprint}, scene_.noise);
    }
    const float sun = scene_.field->sunlight(p.at, face.normal);
    if (sun > 0) arriving += rig_.sun_colour * (sun * dot(face.normal, rig_.sun_way) * shade.near);
    return (colour * arriving + shade.shine) * rig_.exposure;
}

// Light that a point sends to the eye. Mirrors show no other mirrors; through glass the surface behind it is seen, also through the
// next `panes` - 1 panes.
Vec Painter::linear(const Point& p, Vec way, int panes) const {
    if (p.face.triangle < 0) return SKY;
    return through(p, way, panes, lit(p, shade(p, way)));
}

// Adds to the `own` light of a point what it mirrors, or what is seen through it.
Vec Painter::through(const Point& p, Vec way, int panes, Vec own) const {
    const Material& material = *p.face.material;
    if (panes == 0 || material.gloss < MIRROR || (panes < PANES && !material.clear)) return own;
    const Vec normal = p.face.normal;
    Vec from = p.at + way * (PANE_M / length(way)), on = way;
    if (!material.clear) {
        from = p.at + normal * LIFT_M;
        on = way - normal * (2.0f * dot(way, normal));
    }
    float share = (material.gloss - 0.7f) / 0.3f;
    share *= share * 0.85f;
    return mix(own, linear(followed(from, on), on, panes - 1), share);
}

// Paints the pixels first to end of a row, all of one triangle.
void Painter::paint_run(const Canvas& canvas, int y, int first, int end, const Images& images) {
    const size_t start = size_t(y) * canvas.width;
    int triangle;
    const Whose whose = owner(canvas.triangle[start + first], triangle);
    const Mesh& mesh = solid(whose).mesh;
    const float row = float(y) + 0.5f;
    const Vec aside = camera_.up * camera_.upwards(row), eye = camera_.flat ? camera_.eye + aside : camera_.eye;
    const Vec base = camera_.flat ? camera_.forward : aside + camera_.forward;
    const Vecd corner(mesh.corner(triangle, 0)), e = Vecd(mesh.corner(triangle, 1)) - corner, f = Vecd(mesh.corner(triangle, 2)) - corner;
    const Vecd plane = cross(e, f);
    // distance = height / slope; of the two, the slope grows along the row in a perspective view, and the height in a parallel one
    const double inverse_area = 1.0 / std::sqrt(dot(plane, plane));
    const float height = float(dot(plane, corner - Vecd(eye)) * inverse_area), slope = float(dot(plane, Vecd(base)) * inverse_area);
    const float grows = float(dot(plane, Vecd(camera_.right)) * inverse_area);
    const float high = 1.0f + camera_.upwards(row) * camera_.upwards(row);
    Point p;
    Vec way;
    const auto move = [&](int x) {
        const float u = across_[x];
        float distance;
        if (camera_.flat) {
            distance = (height - u * grows) / slope;
            way = base;
            p.at = eye + camera_.right * u + way * distance;
            p.footprint = pixel_ / larger(std::fabs(slope), 0.2f);
        } else {
            const float inverse = 1.0f / (slope + u * grows), square = high + u * u;
            distance = height * inverse;
            way = base + camera_.right * u;
            p.at = eye + way * distance;
            p.footprint = pixel_ * distance * square * smaller(std::fabs(inverse), 5.0f);
        }
        return distance;
    };
    const bool flat = solid(whose).flat[triangle];
    const Vec a = mesh.normal(triangle, 0), to_b = mesh.normal(triangle, 1) - a, to_c = mesh.normal(triangle, 2) - a;
    Vec to_u, to_v;  // how the barycentric coordinates grow
    if (flat || !wanted_) {
        p.face = face(whose, triangle, unit(a), camera_.way(float(first) + 0.5f, row));
    } else {
        to_u = narrow(cross(f, plane) * (inverse_area * inverse_area));
        to_v = narrow(cross(plane, e) * (inverse_area * inverse_area));
    }
    const auto turn = [&] {
        const Vec from = p.at - narrow(corner);
        const float u = clamp(dot(from, to_u), 0.0f, 1.0f), v = clamp(dot(from, to_v), 0.0f, 1.0f);
        p.face = face(whose, triangle, unit(a + to_b * u + to_c * v), way);
    };
    Shade left, right;
    int left_x = first, right_x = first - 1;
    float share = 0, shares = 0;
    for (int x = first; x < end; ++x) {
        const size_t n = start + x;
        images.ids[n] = mesh.instance[triangle];
        images.depth[n] = move(x);
        if (!wanted_) continue;
        if (!flat && (x > right_x || images.normals)) turn();
        normals_[n] = p.face.normal;
        if (!images.rgb) continue;
        if (x > right_x) {
            left = right_x < first ? shade(p, way) : right;
            left_x = right_x < first ? x : right_x;
            right_x = std::min(left_x + (STRIDE * p.footprint < SMOOTH_M ? STRIDE : 1), end - 1);
            if (right_x > left_x) {
                const Point here = p;
                const Vec along = way;
                move(right_x);
                if (!flat) turn();
                right = shade(p, way);
                p = here, way = along;
                shares = 1.0f / float(right_x - left_x);
            }
            share = shares * float(x - left_x);
        }
        light_[n] = lit(p, right_x > left_x ? mix(left, right, share) : left);
        if (p.face.material->gloss >= MIRROR) light_[n] = through(p, way, PANES, light_[n]);
        share += shares;
    }
}

// Writes the picture from the light of all pixels. An edge pixel is the mean of two samples: of its centre, and of a point towards a
// neighbour on another face or at another depth, which has the light of the pixel whose triangle covers it.
void Painter::smooth_edges(const Canvas& canvas, const Images& images) {
    const auto differ = [&](size_t n, size_t m) {
        if (canvas.triangle[n] == canvas.triangle[m]) return false;
        const Vec a = light_[n], b = light_[m];
        const float unlike = std::fabs(a.x - b.x) + std::fabs(a.y - b.y) + std::fabs(a.z - b.z);
        const float bright = 0.5f * (sum(a) + sum(b)) + 0.03f;
        if (unlike < BETWEEN * bright) return false;
        if (images.ids[n] != images.ids[m]) return true;
        if (canvas.triangle[n] < 0 || canvas.triangle[m] < 0 || unlike <= WITHIN * bright) return false;
        return dot(normals_[n], normals_[m]) < 0.8f ||
               std::fabs(images.depth[n] - images.depth[m]) > 0.06f * smaller(images.depth[n], images.depth[m]);
    };
    // where both neighbours on a line differ, the second sample lies towards the first of them
    std::vector<int8_t> aside(light_.size()), down(light_.size());
    const auto note = [](int8_t& here, int8_t& there) {
        if (here == 0) here = 1;
        if (there == 0) there = -1;
    };
    for (int y = 0; y < canvas.height; ++y) {
        for (int x = 0; x < canvas.width; ++x) {
            const size_t n = size_t(y) * canvas.width + x;
            if (x + 1 < canvas.width && differ(n, n + 1)) note(aside[n], aside[n + 1]);
            if (y + 1 < canvas.height && differ(n, n + canvas.width)) note(down[n], down[n + canvas.width]);
        }
    }
    const auto shown = [&](float x) { return scene_.curve[int(clamp(x * ((CURVE - 1) / BRIGHTEST), 0.0f, float(CURVE - 1)))]; };
    for (int y = 0; y < canvas.height; ++y) {
        for (int x = 0; x < canvas.width; ++x) {
            const size_t n = size_t(y) * canvas.width + x;
            uint8_t* out = images.rgb + 3 * n;
            if (images.sky && canvas.triangle[n] < 0) {
                std::memcpy(out, images.sky, 3);
                continue;
            }
            const Vec first = light_[n];
            if (aside[n] == 0 && down[n] == 0) {
                for (int k = 0; k < 3; ++k) out[k] = uint8_t(shown(first[k]) + 0.5f);
                continue;
            }
            // averaged after the curve, not as light, so that bright edges stay smooth
            const Vec second = light_[covering(canvas, x, y, aside[n], down[n])];
            for (int k = 0; k < 3; ++k) out[k] = uint8_t(0.5f * (shown(first[k]) + shown(second[k])) + 0.5f);
        }
    }
}

void Painter::draw(const Images& images) {
    const Projection onto = Projection::of(camera_);
    Canvas canvas(camera_.width, camera_.height);
    rasterise(fixed_.mesh, fixed_.runs, hidden(), 0, onto, canvas);
    rasterise(moved_.mesh, moved_.runs, nullptr, fixed_.mesh.count, onto, canvas);
    rasterise(scene_.extra->mesh, scene_.extra->runs, nullptr, fixed_.mesh.count + moved_.mesh.count, onto, canvas);

    const size_t total = size_t(canvas.width) * canvas.height;
    wanted_ = images.rgb || images.normals;
    normals_.resize(wanted_ ? total : 0);
    light_.resize(images.rgb ? total : 0);
    for (int y = 0; y < canvas.height; ++y) {
        const size_t start = size_t(y) * canvas.width;
        for (int x = 0; x < canvas.width;) {
            const int number = canvas.triangle[start + x];
            if (number < 0) {
                images.ids[start + x] = -1;
                images.depth[start + x] = camera_.far;
                if (images.rgb) light_[start + x] = SKY;
                ++x;
                continue;
            }
            int end = x + 1;
            while (end < canvas.width && canvas.triangle[start + end] == number) ++end;
            paint_run(canvas, y, x, end, images);
            x = end;
        }
    }
    if (images.normals) {
        for (size_t n = 0; n < total; ++n) {
            const Vec normal = normals_[n];
            images.normals[3 * n] = normal.x, images.normals[3 * n + 1] = normal.y, images.normals[3 * n + 2] = normal.z;
        }
    }
    if (images.rgb) smooth_edges(canvas, images);
}

}  // namespace

void draw(const Scene& scene, const Camera& camera, const Images& images) { Painter(scene, camera).draw(images); }

}  // namespace ovman
