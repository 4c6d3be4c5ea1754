#include "light.hpp"

#include <algorithm>
#include <map>
#include <tuple>

namespace ovman {
namespace {

constexpr float STEP_M = 0.08f;       // between nodes
constexpr float INSET_M = 0.01f;      // of the outermost nodes: in the very corner of a room all is dark
constexpr float REACH_M = 0.55f;      // range of contact darkening
constexpr float SUN_STEP_M = 0.0125f; // width of a pixel of the sun's view through a pane
constexpr int MOST = 512;             // nodes or pixels along an axis
constexpr float THIN_M = 0.05f;       // a rectangle that is narrower is on a rail or a frame, which no lamp leaves dark: its few
constexpr float LEAST = 0.35f;        // nodes say little. It has at least this share of a lamp's light
constexpr float FEEBLE = 0.004f;      // share of the light at a point below which a lamp casts no rays
constexpr int AROUND = 12;            // directions into the surroundings
constexpr size_t SURE = 3;            // rays that agree decide for the others
// Directions about +z, distributed as the cosine: the golden angle in a disc of even area. The first of them are far apart.
struct Directions {
    Vec way[AROUND];
    Directions() {
        double c = 1, s = 0;
        for (int k = 0; k < AROUND; ++k) {
            const double square = (k + 0.5) / AROUND, radius = std::sqrt(square);
            way[k * 5 % AROUND] = {float(radius * c), float(radius * s), float(std::sqrt(1 - square))};
            const double turned = c * -0.7373688780783197 - s * 0.6754902942615238;  // cosine and sine of 2.399963229728653
            s = c * 0.6754902942615238 + s * -0.7373688780783197;
            c = turned;
        }
    }
};
const Directions DIRECTIONS;

// The light of one lamp at a point, as a factor of its colour, and the way to it.
struct Beam {
    float bright, power;  // with and without the cosine of the surface
    Vec way;
};

Beam beam(const Lamp& lamp, Vec point, Vec normal) {
    const Vec way = lamp.position - point;
    const float cosine = dot(way, normal);
    if (cosine <= 0) return {0, 0, way};
    const float inverse = 1.0f / std::sqrt(dot(way, way) + lamp.softening);
    const float shine = lamp.aimed ? -dot(way, lamp.axis) * inverse : 1.0f;
    if (shine <= 0) return {0, 0, way};
    const float power = shine * inverse * inverse * inverse;
    return {power * cosine, power, way};
}

// Scales the direction of the light so that its length along the normal is 1.
Glow finished(Glow glow, Vec normal) {
    const float along = dot(glow.way, normal);
    glow.way = along > 0 ? glow.way * (1.0f / along) : normal;
    return glow;
}

float segment_gap(Vec centre, Vec from, Vec to) {
    const Vec along = to - from;
    const float share = clamp(dot(centre - from, along) / larger(dot(along, along), 1e-12f), 0.0f, 1.0f);
    return length(centre - from - along * share);
}

// The point of a chart's triangles under (u, v), the outermost one, or the nearest to it; and the normal there.
void locate(const Mesh& mesh, const Charts& charts, const Chart& chart, float u, float v, Vec& point, Vec& normal) {
    float best_gap = 1e30f, best_height = -1e30f;
    for (int i = chart.first; i < chart.end; ++i) {
        const int t = charts.triangles[i];
        float x[3], y[3];
        for (int k = 0; k < 3; ++k) {
            const Vec corner = mesh.corner(t, k);
            x[k] = mesh.local(chart.part, chart.u_axis, corner) - u;
            y[k] = mesh.local(chart.part, chart.v_axis, corner) - v;
        }
        const float area = (x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]);
        float w[3] = {0, 0, 0}, gap = 1e30f;
        bool inside = area != 0;
        for (int k = 0; k < 3; ++k) {
            const int a = (k + 1) % 3, b = (k + 2) % 3;
            w[k] = area != 0 ? (x[a] * y[b] - x[b] * y[a]) / area : 0;
            inside &= w[k] >= 0;
        }
        if (inside) {
            gap = 0;
        } else {
            for (int k = 0; k < 3; ++k) {
                const int b = (k + 1) % 3;
                const float dx = x[b] - x[k], dy = y[b] - y[k];
                const float s = clamp(-(x[k] * dx + y[k] * dy) / larger(dx * dx + dy * dy, 1e-12f), 0.0f, 1.0f);
                const float nx = x[k] + s * dx, ny = y[k] + s * dy, far = nx * nx + ny * ny;
                if (far >= gap) continue;
                gap = far;
                w[0] = w[1] = w[2] = 0;
                w[k] = 1 - s;
                w[b] = s;
            }
        }
        if (gap > best_gap) continue;
        const Vec p = mesh.corner(t, 0) * w[0] + mesh.corner(t, 1) * w[1] + mesh.corner(t, 2) * w[2];
        const float height = mesh.local(chart.part, chart.axis, p) * (chart.positive ? 1.0f : -1.0f);
        if (gap == best_gap && height <= best_height) continue;
        best_gap = gap;
        best_height = height;
        point = p;
        normal = unit(mesh.normal(t, 0) * w[0] + mesh.normal(t, 1) * w[1] + mesh.normal(t, 2) * w[2]);
    }
}

}  // namespace

Glow direct(const Rig& rig, Vec point, Vec normal) {
    Glow glow{{}, {}, 1};
    for (const Lamp& lamp : rig.lamps) {
        const Beam b = beam(lamp, point, normal);
        glow.light += lamp.colour * b.bright;
        glow.way += b.way * (b.power * sum(lamp.colour));
    }
    return finished(glow, normal);
}

Charts::Charts(const Mesh& mesh) : of_triangle(mesh.count, -1) {
    std::map<std::tuple<int, int, bool>, int> numbers;
    std::vector<float> low_u, high_u, low_v, high_v;
    int last_part = -1;
    for (int t = 0; t < mesh.count; ++t) {
        const int part = mesh.part[t], axis = mesh.axis[t];
        if (part != last_part) numbers.clear();  // parts are runs
        last_part = part;
        const Vec a = mesh.corner(t, 0);
        const Vec winding = narrow(cross(Vecd(mesh.corner(t, 1) - a), Vecd(mesh.corner(t, 2) - a)));
        const bool positive = dot(winding, mesh.row(part, axis)) > 0;
        const auto [found, fresh] = numbers.try_emplace({part, axis, positive}, int(charts.size()));
        const int number = of_triangle[t] = found->second;
        if (fresh) {
            Chart chart{};
            chart.part = part;
            chart.axis = axis;
            chart.positive = positive;
            chart.u_axis = axis == 0 ? 2 : 0;
            chart.v_axis = axis == 1 ? 2 : 1;
            charts.push_back(chart);
            low_u.push_back(1e30f), high_u.push_back(-1e30f), low_v.push_back(1e30f), high_v.push_back(-1e30f);
        }
        Chart& chart = charts[number];
        ++chart.end;
        for (int k = 0; k < 3; ++k) {
            const Vec p = mesh.corner(t, k);
            const float u = mesh.local(part, chart.u_axis, p), v = mesh.local(part, chart.v_axis, p);
            low_u[number] = smaller(low_u[number], u), high_u[number] = larger(high_u[number], u);
            low_v[number] = smaller(low_v[number], v), high_v[number] = larger(high_v[number], v);
            chart.box.add(p);
        }
    }
    int next = 0;
    for (size_t n = 0; n < charts.size(); ++n) {
        Chart& chart = charts[n];
        const int count = chart.end;
        chart.first = chart.end = next;
        next += count;
        const auto nodes = [](float low, float high, float& start, float& step) {
            const float span = high - low;
            if (!(span > 0.7f * STEP_M)) {
                start = 0.5f * (low + high);
                step = 1;
                return 1;
            }
            const int count = std::min(MOST, int(std::ceil(span / STEP_M)) + 1);
            const float inset = smaller(INSET_M, 0.1f * span);
            start = low + inset;
            step = (span - 2 * inset) / float(count - 1);
            return count;
        };
        chart.columns = nodes(low_u[n], high_u[n], chart.u0, chart.du);
        chart.rows = nodes(low_v[n], high_v[n], chart.v0, chart.dv);
        chart.per_u = 1 / chart.du;
        chart.per_v = 1 / chart.dv;
        chart.node = node_count;
        node_count += chart.columns * chart.rows;
    }
    triangles.resize(mesh.count);
    for (int t = 0; t < mesh.count; ++t) triangles[charts[of_triangle[t]].end++] = t;
}

Solid::Solid(const Mesh& mesh) : mesh(mesh), runs(runs_of(mesh)), tree(mesh), charts(mesh), flat(mesh.count) {
    for (int t = 0; t < mesh.count; ++t) {
        const Vec a = mesh.normal(t, 0);
        flat[t] = dot(a, mesh.normal(t, 1)) > 0.99999f && dot(a, mesh.normal(t, 2)) > 0.99999f;
    }
}

Field::Field(std::shared_ptr<const Solid> fixed, std::vector<uint8_t> hidden, std::shared_ptr<const Solid> moved, Rig rig,
             std::shared_ptr<Field> before, std::vector<Ball> changes)
    : fixed_(std::move(fixed)), moved_(std::move(moved)), hidden_(std::move(hidden)), rig_(std::move(rig)),
      before_(std::move(before)), changes_(std::move(changes)) {
    const std::vector<Chart>& charts = fixed_->charts.charts;
    shared_.assign(charts.size(), 0);
    int count = 0;
    for (size_t n = 0; n < charts.size(); ++n) {
        shared_[n] = before_ && !reaches(charts[n].box.middle(), charts[n].box.radius());
        if (!shared_[n]) count += charts[n].columns * charts[n].rows;
    }
    own_[0].resize(count);
    Glow* next = own_[0].data();
    for (size_t n = 0; n < charts.size(); ++n) {
        charts_[0].push_back(shared_[n] ? before_->charts_[0][n] : next);
        if (!shared_[n]) next += charts[n].columns * charts[n].rows;
    }
    own_[1].resize(moved_->charts.node_count);
    for (const Chart& chart : moved_->charts.charts) charts_[1].push_back(own_[1].data() + chart.node);
}

// Whether a change may alter the light within `radius` of a point.
bool Field::reaches(Vec point, float radius) const {
    for (const Ball& ball : changes_) {
        if (length(point - ball.centre) < radius + ball.radius + REACH_M) return true;
        for (const Sample& sample : rig_.samples)
            if (segment_gap(ball.centre, point, sample.point) < radius + ball.radius + LIFT_M) return true;
    }
    return false;
}

bool Field::blocked(Vec origin, Vec way, float reach) const {
    return fixed_->tree.blocked(origin, way, reach, hidden_.empty() ? nullptr : hidden_.data()) ||
           moved_->tree.blocked(origin, way, reach, nullptr);
}

Glow Field::compute(Vec point, Vec normal, float least) const {
    Glow glow{{}, {}, 0};
    const Vec origin = point + normal * LIFT_M;
    float lit[MOST_LAMPS] = {}, bright[MOST_LAMPS], total = 0;
    for (size_t k = 0; k < rig_.lamps.size(); ++k) total += bright[k] = beam(rig_.lamps[k], point, normal).bright * sum(rig_.lamps[k].colour);
    for (size_t first = 0, end; first < rig_.samples.size(); first = end) {
        const int lamp = rig_.samples[first].lamp;
        float seen = 0, tried = 0;
        for (end = first; end < rig_.samples.size() && rig_.samples[end].lamp == lamp; ++end) {
            // where the first samples agree, so do the others
            if (bright[lamp] <= FEEBLE * total || (end - first >= SURE && (seen == 0 || seen == tried))) continue;
            const Sample& sample = rig_.samples[end];
            const Vec way = sample.point - origin;
            const float reach = larger(1.0f - sample.clearance / larger(length(way), 1e-3f), 0.0f);
            tried += sample.share;
            if (!blocked(origin, way, reach)) seen += sample.share;
        }
        if (tried > 0) lit[lamp] = seen / tried;
    }
    for (size_t k = 0; k < rig_.lamps.size(); ++k) {
        const Lamp& lamp = rig_.lamps[k];
        const Beam b = beam(lamp, point, normal);
        const float share = int(k) < rig_.shadowed ? least + (1.0f - least) * lit[k] : 1.0f;
        glow.light += lamp.colour * (b.bright * share);
        glow.way += b.way * (b.power * sum(lamp.colour) * (0.02f + 0.98f * share));
    }
    // a frame about the normal, continuous except at one sign change of a coordinate (Duff et al. 2017)
    const float sign = normal.z >= 0 ? 1.0f : -1.0f, a = -1.0f / (sign + normal.z), b = normal.x * normal.y * a;
    const Vec first{1.0f + sign * normal.x * normal.x * a, sign * b, -sign * normal.x};
    const Vec second{b, sign + normal.y * normal.y * a, -normal.y};
    int free = 0, tried = 0;
    for (const Vec& d : DIRECTIONS.way) {
        if (tried > int(SURE) && free == tried) break;
        free += !blocked(origin, first * d.x + second * d.y + normal * d.z, REACH_M);
        ++tried;
    }
    glow.open = (float(free) + 0.5f) / (float(tried) + 0.5f);
    return finished(glow, normal);
}

void Field::fill(bool moved, int chart, int number) {
    if (!moved && shared_[chart]) return before_->fill(false, chart, number);
    Glow& glow = charts_[moved][chart][number];
    const Solid& solid = moved ? *moved_ : *fixed_;
    const Chart& c = solid.charts.charts[chart];
    Vec point, normal;
    const float u = c.u0 + c.du * float(number % c.columns), v = c.v0 + c.dv * float(number / c.columns);
    locate(solid.mesh, solid.charts, c, u, v, point, normal);
    if (moved || !before_ || reaches(point, 0)) {
        const float narrowest = smaller(c.du * float(c.columns), c.dv * float(c.rows));
        glow = compute(point, normal, narrowest < THIN_M || c.columns == 1 || c.rows == 1 ? LEAST : 0.0f);
        return;
    }
    Glow& same = before_->charts_[0][chart][number];
    if (same.open < 0) before_->fill(false, chart, number);
    glow = same;
}

Glow Field::at(bool moved, int triangle, Vec point) {
    const Solid& solid = moved ? *moved_ : *fixed_;
    const int number = solid.charts.of_triangle[triangle];
    const Chart& c = solid.charts.charts[number];
    Glow* nodes = charts_[moved][number];
    const float x = clamp((solid.mesh.local(c.part, c.u_axis, point) - c.u0) * c.per_u, 0.0f, float(c.columns - 1));
    const float y = clamp((solid.mesh.local(c.part, c.v_axis, point) - c.v0) * c.per_v, 0.0f, float(c.rows - 1));
    // the cell whose corners are a, b in a row and c, d in the next; a chart of one column or row has no second one
    const int i = std::min(int(x), std::max(c.columns - 2, 0)), j = std::min(int(y), std::max(c.rows - 2, 0));
    const int a = j * c.columns + i, b = a + (c.columns > 1), below = c.rows > 1 ? c.columns : 0;
    const int four[4] = {a, b, a + below, b + below};
    for (int k : four)
        if (nodes[k].open < 0) fill(moved, number, k);
    const float fu = x - float(i), fv = y - float(j);
    const float weights[4] = {(1 - fu) * (1 - fv), fu * (1 - fv), (1 - fu) * fv, fu * fv};
    Glow glow{{}, {}, 0};
    for (int k = 0; k < 4; ++k) {
        const Glow& g = nodes[four[k]];
        glow.light += g.light * weights[k];
        glow.way += g.way * weights[k];
        glow.open += g.open * weights[k];
    }
    return glow;
}

// Draws what lies behind each pane as the sun sees it, up to the first surface.
void Field::open_panes() {
    opened_ = true;
    for (const Pane& pane : rig_.panes) {
        const int along = 2 - pane.axis;
        const Vec w = rig_.sun_way;
        Projection onto{};
        // a point is `depth` metres from the plane of the pane, along the sun's rays
        const double rate = -1.0 / w[pane.axis];
        const auto axis = [](int a, double k) { return Vecd(a == 0 ? k : 0, a == 1 ? k : 0, a == 2 ? k : 0); };
        onto.forward = axis(pane.axis, rate);
        onto.at_forward = -rate * pane.plane;
        const double half_u = 0.5 * (pane.high - pane.low), half_v = 0.5 * (pane.top - pane.bottom);
        onto.right = (axis(along, 1) + onto.forward * w[along]) * (1 / half_u);
        onto.at_right = (onto.at_forward * w[along] - 0.5 * (pane.low + pane.high)) / half_u;
        onto.up = (axis(1, 1) + onto.forward * w.y) * (1 / half_v);
        onto.at_up = (onto.at_forward * w.y - 0.5 * (pane.bottom + pane.top)) / half_v;
        onto.near = 1e-4;
        onto.far = 1e3;
        onto.width = std::clamp(int(2 * half_u / SUN_STEP_M), 1, MOST);
        onto.height = std::clamp(int(2 * half_v / SUN_STEP_M), 1, MOST);
        Canvas canvas(onto.width, onto.height);
        rasterise(fixed_->mesh, fixed_->runs, hidden_.empty() ? nullptr : hidden_.data(), 0, onto, canvas);
        rasterise(moved_->mesh, moved_->runs, nullptr, 0, onto, canvas);
        shade_.push_back(std::move(canvas));
    }
}

// Fraction of the sun's light at a point that faces it.
float Field::through_panes(Vec p) {
    if (!opened_) open_panes();
    const Vec w = rig_.sun_way;
    for (size_t k = 0; k < rig_.panes.size(); ++k) {
        const Pane& pane = rig_.panes[k];
        const float depth = (pane.plane - p[pane.axis]) * pane.per_depth;
        const float across = p[2 - pane.axis] + depth * w[2 - pane.axis], y = p.y + depth * w.y;
        if (depth < 0.02f || across <= pane.low || across >= pane.high || y <= pane.bottom || y >= pane.top) continue;
        const Canvas& canvas = shade_[k];
        const float x = (across - pane.low) / (pane.high - pane.low) * float(canvas.width) - 0.5f;
        const float z = (pane.top - y) / (pane.top - pane.bottom) * float(canvas.height) - 0.5f;
        const float fx = x - std::floor(x), fz = z - std::floor(z);
        float lit = 0;
        for (int b = 0; b < 2; ++b) {
            for (int a = 0; a < 2; ++a) {
                const int i = std::clamp(int(std::floor(x)) + a, 0, canvas.width - 1);
                const int j = std::clamp(int(std::floor(z)) + b, 0, canvas.height - 1);
                const float met = -canvas.nearness[size_t(j) * canvas.width + i];
                if (depth <= met + 0.02f) lit += (a ? fx : 1 - fx) * (b ? fz : 1 - fz);
            }
        }
        return lit;
    }
    return 0;
}

}  // namespace ovman
