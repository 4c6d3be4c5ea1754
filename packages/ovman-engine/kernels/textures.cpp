#include "textures.hpp"

namespace ovman {
namespace {

// A number in [0, 1) that is a function of three integers.
float hash(int64_t a, int64_t b, int64_t c) {
    uint32_t h = uint32_t(a) * 374761393u + uint32_t(b) * 668265263u + uint32_t(c) * 2246822519u;
    h = (h ^ (h >> 13)) * 1274126177u;
    h ^= h >> 16;
    return float(h & 0xFFFFFF) * (1.0f / 16777216.0f);
}

int64_t whole(float x) { return int64_t(std::floor(x)); }
float fraction(float x) { return x - std::floor(x); }

// The sine to 1e-3. The library's differs between platforms.
float sine(float x) {
    const float turn = x * 0.15915494f, t = 2.0f * fraction(turn + 0.5f) - 1.0f, s = 4.0f * t * (1.0f - std::fabs(t));
    return 0.225f * (s * std::fabs(s) - s) + s;
}

// A noise table at (x, y) in cells, wrapped around, bilinear.
float look(const float* noise, Noise k, float x, float y) {
    const int64_t ix = whole(x), iy = whole(y);
    const float tx = x - float(ix), ty = y - float(iy);
    const float* table = noise + size_t(k) * TILE * TILE;
    const float* top = table + (iy & (TILE - 1)) * TILE;
    const float* low = table + ((iy + 1) & (TILE - 1)) * TILE;
    const int64_t x0 = ix & (TILE - 1), x1 = (ix + 1) & (TILE - 1);
    const float a = top[x0] * (1.0f - tx) + top[x1] * tx, b = low[x0] * (1.0f - tx) + low[x1] * tx;
    return a * (1.0f - ty) + b * ty;
}

// 1 if a structure of this period is well resolved, 0 if pixels are as wide as it.
float resolved(float footprint, float period) { return clamp(1.6f - 2.0f * footprint / period, 0.0f, 1.0f); }

// A second colour for a pattern: lighter or darker, slightly turned in hue.
Vec second(Vec c, int32_t seed) {
    const float turn = 0.25f * hash(seed, 71, 5), mean = 0.33f * sum(c);
    const Vec turned = c + (Vec{c.y, c.z, c.x} - c) * turn;
    if (mean > 0.30f - 0.12f * hash(seed, 72, 5)) return turned * (0.30f + 0.25f * hash(seed, 73, 5));
    return mix(turned, {0.85f, 0.82f, 0.76f}, 0.35f + 0.25f * hash(seed, 73, 5));
}

// In the pictures below, s runs to the right and t upwards, both from 0 to 1.

// Two ridges or a shore under a sky with a sun.
Vec landscape(float s, float t, Vec c, int32_t seed) {
    const Vec other = second(c, seed);
    const float line = 0.25f + 0.25f * hash(seed, 12, 0);
    const float wave = 6.3f * (s * (1.0f + 2.0f * hash(seed, 13, 0)) + hash(seed, 14, 0));
    const float near = line + 0.06f * sine(wave), far = line + 0.14f + 0.12f * std::fabs(sine(wave * 0.7f + 2.0f));
    if (t < near) return other * (0.55f + 0.45f * t / near);
    if (t < far) return (c + other) * 0.25f + Vec{0.0f, 0.02f, 0.04f};
    const float x = s - (0.2f + 0.6f * hash(seed, 15, 0)), y = t - 0.8f;
    if (x * x + y * y < 0.008f) return {0.9f, 0.6f, 0.3f};
    const float k = (t - far) / (1.0f - far), warm = hash(seed, 16, 0);
    return {0.75f - 0.45f * k * (1.0f - warm * 0.6f), 0.68f - 0.25f * k, 0.6f - 0.05f * k + 0.1f * (1.0f - warm)};
}

// Head and shoulders before a plain ground.
Vec portrait(float s, float t, Vec c, int32_t seed) {
    const float x = (s - 0.5f) * 2.0f, lean = 0.1f * (hash(seed, 17, 0) - 0.5f), tone = 0.35f + 0.65f * hash(seed, 18, 0);
    const float dark = 0.02f + 0.22f * hash(seed, 19, 0) * hash(seed, 19, 1);
    const Vec hair{dark, dark * 0.6f, dark * 0.35f};
    float dx = (x - lean) / 0.34f, dy = (t - 0.6f) / 0.21f;
    if (dx * dx + dy * dy < 1.0f) {
        const bool eyes = std::fabs(std::fabs(x - lean) - 0.13f) < 0.045f && std::fabs(t - 0.63f) < 0.018f;
        const bool mouth = std::fabs(x - lean) < 0.1f && std::fabs(t - 0.49f) < 0.01f;
        if (dy > 0.45f - 0.3f * std::fabs(dx)) return hair;
        if (eyes || mouth) return {0.1f, 0.04f, 0.03f};
        return Vec{0.72f, 0.45f, 0.32f} * tone;
    }
    dx = (x - lean) / (0.42f + 0.1f * hash(seed, 19, 2)), dy = (t - 0.58f) / 0.3f;
    if (dx * dx + dy * dy < 1.0f) return hair;
    dx = x / 0.85f, dy = (t - 0.02f) / 0.38f;
    if (dx * dx + dy * dy < 1.0f || (std::fabs(x - lean) < 0.13f && t < 0.5f)) return c;
    return second(c, seed);
}

// A vase of flowers on a table.
Vec still_life(float s, float t, Vec c, int32_t seed) {
    const Vec other = second(c, seed);
    for (int i = 0; i < 7; ++i) {
        const float x = s - (0.5f + 0.5f * (hash(seed, 40 + i, 1) - 0.5f)), y = t - (0.62f + 0.24f * hash(seed, 40 + i, 2));
        const float size = 0.05f + 0.05f * hash(seed, 40 + i, 3), far = x * x + y * y;
        if (far < 0.1f * size * size) return {0.8f, 0.6f, 0.1f};
        if (far < size * size) return i & 1 ? Vec{0.75f, 0.18f, 0.2f} : Vec{0.85f, 0.75f, 0.7f};
    }
    const float x = std::fabs(s - 0.5f);
    if (t > 0.42f && t < 0.66f && x < 0.3f * (t - 0.3f)) return {0.06f, 0.2f, 0.07f};
    if (t > 0.14f && t < 0.46f && x < 0.15f - 1.6f * (t - 0.28f) * (t - 0.28f)) return c;
    return t < 0.24f ? other * 0.5f : other;
}

// A framed picture: a landscape, a portrait, flowers or shapes.
Vec picture(float s, float t, Vec c, int32_t seed) {
    const float style = hash(seed, 11, 0);
    if (style < 0.4f) return landscape(s, t, c, seed);
    if (style < 0.55f) return portrait(s, t, c, seed);
    if (style < 0.7f) return still_life(s, t, c, seed);
    const Vec other = second(c, seed);
    Vec shown{0.72f, 0.68f, 0.6f};
    for (int i = 0; i < 6; ++i) {
        const float x = s - hash(seed, 20 + i, 1), y = t - hash(seed, 20 + i, 2);
        const float w = 0.08f + 0.28f * hash(seed, 20 + i, 3), h = 0.08f + 0.28f * hash(seed, 20 + i, 4);
        const bool inside = style > 0.86f ? x * x + y * y < w * w : std::fabs(x) < w && std::fabs(y) < h;
        if (inside) shown = (i & 1 ? c : other) * (0.35f + 0.9f * hash(seed, 20 + i, 5));
    }
    return {smaller(shown.x, 1.0f), smaller(shown.y, 1.0f), smaller(shown.z, 1.0f)};
}

// The view through a window: clouds, far hills, trees, a lawn. u, v: metres.
Vec outdoors(float s, float t, float u, float v, Vec c, int32_t seed, const float* noise) {
    (void)s;
    const float shift = 100.0f * hash(seed, 50, 0), line = 0.24f + 0.16f * hash(seed, 51, 0);
    const float trees = line + 0.1f + 0.12f * look(noise, CLOUDS, u * 90.0f + shift, shift);
    const float hills = line + 0.14f + 0.06f * sine(u * 2.5f + shift);
    if (t < line - 0.08f) return Vec{0.20f, 0.27f, 0.11f} * (0.8f + 0.12f * look(noise, CLOUDS, u * 60.0f, v * 240.0f + shift));
    if (t < trees) {
        const float k = 0.75f + 0.45f * look(noise, CLOUDS, u * 420.0f + shift, v * 420.0f);
        return Vec{0.13f, 0.20f, 0.08f} * (k * (0.55f + 0.7f * (t - line + 0.1f)));
    }
    if (t < hills) return {0.30f, 0.42f, 0.42f};
    const float low = 1.0f - (t - hills) / (1.0f - hills);
    const float cloud = look(noise, CLOUDS, u * 22.0f + shift, v * 50.0f + shift) * 1.4f;
    return mix(c, {0.95f, 0.96f, 0.98f}, clamp(0.7f * low * low + larger(cloud, 0.0f), 0.0f, 0.95f));
}

// Ink, 0 to 1, at a point of lines of words. `line`: distance between lines, metres.
float ink(float u, float v, float line, float footprint, int32_t seed) {
    const float row = std::floor(v / line), y = v / line - row;
    const float x = u / (3.2f * line) + 7.0f * hash(int64_t(row), seed, 61), k = std::floor(x);
    const float gap = 0.12f + 0.3f * hash(int64_t(row), int64_t(k), seed), sharp = resolved(footprint, line);
    return (y > 0.3f && y < 0.8f && x - k > gap ? 0.72f * sharp : 0.0f) + 0.28f * (1.0f - sharp);
}

// A printed page: a headline, columns of words, a picture among them.
Vec text(Spot at, Vec c, float scale, int32_t seed) {
    if (at.half_u < 0.03f || at.half_v < 0.03f) return c;
    const float s = at.u / (at.half_u + at.half_u) + 0.5f, t = at.v / (at.half_v + at.half_v) + 0.5f;
    if (s < 0.05f || s > 0.95f || t < 0.04f || t > 0.96f) return c;
    float dark = 0;
    if (t < 0.2f) {
        dark = ink(at.u, at.v, 0.14f * at.half_v, at.footprint, seed);
    } else {
        const float columns = larger(std::floor(at.half_u / 0.045f), 2.0f), place = fraction(s * columns);
        if (hash(whole(s * columns), seed, 62) > 0.6f && t > 0.3f && t < 0.55f)
            return c * (0.2f + 0.5f * std::fabs(t - 0.42f) * 4.0f);
        if (place > 0.06f && place < 0.94f) dark = ink(at.u, at.v, scale, at.footprint, seed);
    }
    return c * (1.0f - 0.85f * dark);
}

// A product's print: a coloured band, an emblem, lines of words.
Vec label(float s, float t, Spot at, Vec c, int32_t seed) {
    const float hue = hash(seed, 70, 0);
    const Vec band{0.6f * hue, 0.5f * hash(seed, 70, 1), 0.6f * (1.0f - hue)};
    if (t > 0.72f && t < 0.93f) {
        if (std::fabs(s - 0.5f) >= 0.34f || std::fabs(t - 0.82f) >= 0.06f) return band;
        return mix(band, {0.85f, 0.85f, 0.8f}, ink(at.u, at.v, 0.24f * at.half_v, at.footprint, seed));
    }
    const float x = s - 0.5f, y = (t - 0.5f) * 1.3f;
    if (hash(seed, 71, 0) < 0.5f ? x * x + y * y < 0.03f : std::fabs(x) + std::fabs(y) < 0.22f) return second(c, seed);
    if (t > 0.08f && t < 0.28f && std::fabs(x) < 0.38f)
        return c * (1.0f - 0.8f * ink(at.u, at.v, 0.11f * at.half_v, at.footprint, seed));
    return c;
}

// A lit screen: a film, or windows with text on a desktop.
Vec screen(float s, float t, Spot at, Vec c, int32_t seed) {
    if (hash(seed, 80, 0) < 0.45f) return landscape(s, t, c, seed);
    if (t < 0.06f) {
        const float k = whole(s * 16.0f) % 3 ? 0.12f : 0.5f;
        return {k * 0.8f, k * 0.9f, k};
    }
    for (int i = 0; i < 2; ++i) {
        const float x0 = 0.06f + 0.34f * float(i), y0 = 0.12f + 0.12f * hash(seed, 81 + i, 1);
        const float wide = 0.34f + 0.2f * hash(seed, 81 + i, 2), high = 0.6f;
        if (s <= x0 || s >= x0 + wide || t <= y0 || t >= y0 + high) continue;
        if (t > y0 + high - 0.07f) return {0.12f, 0.2f, 0.42f};
        if (s < x0 + 0.03f || s > x0 + wide - 0.03f || t < y0 + 0.04f) return {0.85f, 0.86f, 0.87f};
        const float k = 0.86f * (1.0f - 0.8f * ink(at.u, at.v, 0.1f * at.half_v, at.footprint, seed + i));
        return {k, k, k};
    }
    return c * (0.5f + 0.5f * t);
}

Vec wood(Spot at, const Material& m, const float* noise) {
    float shift_u = m.shift_u;
    const float shift_v = m.shift_v;
    if (at.half_v > at.half_u) at = {at.v, at.u, at.half_v, at.half_u, at.footprint};
    float tone = 1;
    if (at.half_v > 0.9f) {  // a floor of boards
        const float wide = larger(m.scale, 0.09f), board_m = wide * 8.5f;
        const float row = std::floor(at.v / wide), along = at.u / board_m + hash(int64_t(row), m.seed, 3);
        const float board = std::floor(along), pick = hash(int64_t(row), int64_t(board), m.seed);
        tone = 0.80f + 0.34f * pick;
        shift_u += 9.0f * pick;
        const float across = at.v / wide - row, on = along - board;
        const float gap = smaller(smaller(across, 1.0f - across) * wide, smaller(on, 1.0f - on) * board_m);
        const float seam = 0.004f + at.footprint * 0.5f;
        if (gap < seam) tone *= 1.0f - 0.42f * (1.0f - gap / seam) * 0.004f / (0.002f + at.footprint * 0.5f);
    }
    float k = 0;
    const float sharp = resolved(at.footprint, 0.030f);
    if (sharp > 0) k = look(noise, GRAIN, (at.u + shift_u) * 60.0f, (at.v + shift_v) * 520.0f) * sharp * 0.20f;
    k += look(noise, CLOUDS, (at.u + shift_u) * 30.0f, (at.v + shift_v) * 170.0f) * 0.12f;
    k = tone * (1.0f + k);
    return {m.colour.x * k, m.colour.y * k * (1.0f - 0.03f * (1.0f - k)), m.colour.z * k};
}

Vec tiles(Spot at, const Material& m, const float* noise) {
    const float period = larger(m.scale, 0.04f), a = at.u / period, c = at.v / period, ia = std::floor(a), ic = std::floor(c);
    const float edge = smaller(smaller(a - ia, 1.0f - (a - ia)), smaller(c - ic, 1.0f - (c - ic))) * period;
    const float k = 0.95f + 0.10f * hash(int64_t(ia), int64_t(ic), m.seed) +
                    0.05f * look(noise, CLOUDS, (at.u + m.shift_u) * 80.0f, (at.v + m.shift_v) * 80.0f);
    const Vec tile = m.colour * k;
    const float seam = 0.005f + at.footprint * 0.5f;
    if (edge >= seam) return tile;
    const float grout = 0.33f * sum(m.colour) > 0.3f ? 0.16f : 0.5f;
    return mix(tile, {grout, grout, grout}, smaller((1.0f - edge / seam) * 0.005f / (0.0025f + at.footprint * 0.5f), 1.0f));
}

// Motifs on staggered rows.
Vec print(Spot at, const Material& m, const float* noise) {
    const float period = larger(m.scale, 0.03f), c = at.v / period, ic = std::floor(c);
    const float a = at.u / period + (int64_t(ic) & 1 ? 0.5f : 0.0f);
    const float x = fraction(a) - 0.5f, y = c - ic - 0.5f, far = std::sqrt(x * x + y * y), motif = hash(m.seed, 5, 1);
    float d = std::fabs(x) + std::fabs(y) - 0.32f;
    if (motif < 0.34f) {
        d = far - 0.26f;
    } else if (motif < 0.67f) {
        const float four = x * x * x * x + y * y * y * y - 6.0f * x * x * y * y;
        d = far - 0.24f * (1.0f + 0.5f * four / (far * far * far * far + 1e-6f));
    }
    float w = clamp(0.5f - d / larger(at.footprint / period, 0.02f), 0.0f, 1.0f);
    w = 0.25f + (w - 0.25f) * resolved(at.footprint, period);
    return mix(m.colour, m.other, w) *
           (1.0f + 0.05f * look(noise, CLOUDS, (at.u + m.shift_u) * 90.0f, (at.v + m.shift_v) * 90.0f));
}

}  // namespace

void Material::prepare() {
    other = second(colour, seed);
    shift_u = 37.0f * hash(seed, 1, 1);
    shift_v = 37.0f * hash(seed, 2, 1);
}

Vec texel(const Material& m, Spot at, const float* noise) {
    if (m.texture == Texture::plain) return m.colour;
    const float shift_u = m.shift_u, shift_v = m.shift_v;
    const float u = at.u, v = at.v, footprint = at.footprint;
    const float s = u / (at.half_u + at.half_u) + 0.5f, t = v / (at.half_v + at.half_v) + 0.5f;
    switch (m.texture) {
        case Texture::wood: return wood(at, m, noise);
        case Texture::tiles: return tiles(at, m, noise);
        case Texture::print: return print(at, m, noise);
        case Texture::picture: return picture(s, t, m.colour, m.seed);
        case Texture::outdoors: return outdoors(s, t, u, v, m.colour, m.seed, noise);
        case Texture::text: return text(at, m.colour, m.scale, m.seed);
        case Texture::label: return label(s, t, at, m.colour, m.seed);
        case Texture::fabric: {
            const float sharp = resolved(footprint, 0.016f);
            float k = 1.0f + 0.08f * look(noise, CLOUDS, (u + shift_u) * 90.0f, (v + shift_v) * 90.0f);
            if (sharp > 0) k += 0.10f * look(noise, THREAD, (u + shift_u) * 400.0f, (v + shift_v) * 400.0f) * sharp;
            return m.colour * k;
        }
        case Texture::weave: {
            const float period = larger(m.scale, 0.012f), a = u / period, c = v / period;
            const int64_t ia = whole(a), ic = whole(c);
            const float across = ((ia + ic) & 1 ? fraction(a) : fraction(c)) - 0.5f, sharp = resolved(footprint, period);
            const float bulge = 1.0f - smaller(1.5f, 0.06f / period) * across * across * sharp;
            return m.colour * (bulge * (1.0f + 0.10f * (hash(ia, ic, m.seed) - 0.5f) * sharp));
        }
        case Texture::marble: {
            const float vein = larger(look(noise, VEINS, (u + shift_u) * 70.0f, (v + shift_v) * 70.0f), 0.0f);
            const float k = 1.0f + 0.10f * look(noise, CLOUDS, (u + shift_v) * 60.0f, (v + shift_u) * 60.0f);
            return mix(m.colour * k, m.other, 0.35f * vein * resolved(footprint, 0.06f));
        }
        case Texture::metal: {
            const float sharp = resolved(footprint, 0.01f);
            float k = 1.0f + 0.03f * look(noise, CLOUDS, (u + shift_u) * 40.0f, (v + shift_v) * 40.0f);
            if (sharp > 0) k += 0.05f * look(noise, GRAIN, (u + shift_u) * 12.0f, (v + shift_v) * 1400.0f) * sharp;
            return m.colour * k;
        }
        case Texture::leaves: {
            float k = 1.0f + 0.28f * look(noise, CLOUDS, (u + shift_u) * 500.0f, (v + shift_v) * 500.0f) * resolved(footprint, 0.06f);
            const float across = at.half_u < at.half_v ? v : u;
            if (smaller(at.half_u, at.half_v) < 0.15f && std::fabs(across) < 0.003f) k *= 1.2f;
            return m.colour * (k * (0.8f + 0.4f * hash(m.seed, 3, 1)));
        }
        case Texture::pages: {
            const float period = 0.004f;
            return m.colour * (1.0f - 0.25f * hash(whole(v / period), m.seed, 4) * (0.4f + 0.6f * resolved(footprint, period)));
        }
        case Texture::cardboard: {
            const float k = 1.0f + 0.08f * look(noise, CLOUDS, (u + shift_u) * 60.0f, (v + shift_v) * 200.0f);
            const bool tape = std::fabs(u) < 0.025f && at.half_u > 0.06f;
            return (tape ? m.colour * 0.5f + Vec{0.30f, 0.25f, 0.18f} : m.colour) * k;
        }
        case Texture::checker: {
            const float period = larger(m.scale, 0.02f), w = float((whole(u / period) + whole(v / period)) & 1);
            return mix(m.colour, m.other, 0.5f + (w - 0.5f) * resolved(footprint, period));
        }
        case Texture::stripes: {
            const float period = larger(m.scale, 0.015f), duty = 0.25f + 0.3f * hash(m.seed, 6, 1);
            const float w = clamp((duty - fraction(u / period)) / larger(footprint / period, 0.01f) + 0.5f, 0.0f, 1.0f);
            return mix(m.colour, m.other, duty + (w - duty) * resolved(footprint, period));
        }
        case Texture::screen:
            if (m.emission > 0.05f) return screen(s, t, at, m.colour, m.seed);
            return m.colour * (s + 0.5f * t > 0.9f ? 1.5f : 1.0f);
        case Texture::speckle: {
            const float sharp = resolved(footprint, m.scale), grain = 6.4f / m.scale;
            if (sharp <= 0) return m.colour;
            return m.colour * (1.0f + 0.2f * sharp * look(noise, THREAD, u * grain + 100.0f * shift_u, v * grain + 100.0f * shift_v));
        }
        default: return m.colour;
    }
}

}  // namespace ovman
