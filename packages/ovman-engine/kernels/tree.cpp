#include "tree.hpp"

#include <algorithm>
#include <numeric>

namespace ovman {
namespace {

constexpr float MARGIN_M = 1e-4f;  // boxes are larger than their triangles, more than rounding can move a ray
constexpr int BINS = 12, LEAF = 4;
constexpr int DEEP = 64;   // from here on nodes are halved by number, so that a stack of 96 suffices

float area(const Bounds& b) {
    const Vec d = b.high - b.low;
    return d.x < 0 ? 0.0f : d.x * d.y + d.y * d.z + d.z * d.x;
}

}  // namespace

Tree::Tree(const Mesh& mesh) {
    std::vector<Bounds> boxes(mesh.count);
    std::vector<int32_t> order;
    order.reserve(mesh.count);
    for (int t = 0; t < mesh.count; ++t) {
        bool finite = true;
        for (int k = 0; k < 3; ++k) {
            const Vec p = mesh.corner(t, k);
            finite &= std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
            boxes[t].add(p);
        }
        const Vec margin{MARGIN_M, MARGIN_M, MARGIN_M};
        boxes[t].low = boxes[t].low - margin;
        boxes[t].high = boxes[t].high + margin;
        if (finite) order.push_back(t);
    }
    if (order.empty()) return;
    nodes_.reserve(2 * order.size());
    nodes_.emplace_back();
    split(0, 0, int(order.size()), 0, boxes, order);
    for (int t : order) triangles_.push_back({mesh.corner(t, 0), mesh.corner(t, 1), mesh.corner(t, 2), t});
}

// Builds the node over order[first, end) by the surface area heuristic over bins of the longest axis of the centres.
void Tree::split(int node, int first, int end, int depth, const std::vector<Bounds>& boxes, std::vector<int32_t>& order) {
    Bounds box, centres;
    for (int i = first; i < end; ++i) {
        box.add(boxes[order[i]]);
        centres.add(boxes[order[i]].middle());
    }
    nodes_[node] = {box, first, end - first};
    if (end - first <= LEAF) return;
    const Vec span = centres.high - centres.low;
    const int axis = span.x >= span.y && span.x >= span.z ? 0 : span.y >= span.z ? 1 : 2;
    int middle = (first + end) / 2;
    if (span[axis] > 1e-6f && depth < DEEP) {
        const float low = centres.low[axis], scale = BINS / span[axis];
        const auto bin = [&](int t) { return std::min(BINS - 1, int((boxes[t].middle()[axis] - low) * scale)); };
        Bounds bins[BINS];
        int counts[BINS] = {};
        for (int i = first; i < end; ++i) {
            const int b = bin(order[i]);
            bins[b].add(boxes[order[i]]);
            ++counts[b];
        }
        float right_cost[BINS];
        Bounds sum;
        int count = 0;
        for (int b = BINS - 1; b > 0; --b) {
            sum.add(bins[b]);
            right_cost[b] = area(sum) * float(count += counts[b]);
        }
        sum = Bounds();
        count = 0;
        float least = 1e30f;
        int best = 1;
        for (int b = 1; b < BINS; ++b) {
            sum.add(bins[b - 1]);
            const float cost = area(sum) * float(count += counts[b - 1]) + right_cost[b];
            if (cost < least) least = cost, best = b;
        }
        const auto cut = std::stable_partition(order.begin() + first, order.begin() + end, [&](int t) { return bin(t) < best; });
        middle = int(cut - order.begin());
    }
    if (middle == first || middle == end) middle = (first + end) / 2;
    const int child = int(nodes_.size());
    nodes_.resize(nodes_.size() + 2);
    nodes_[node].first = child;
    nodes_[node].count = 0;
    split(child, first, middle, depth + 1, boxes, order);
    split(child + 1, middle, end, depth + 1, boxes, order);
}

template <bool any> bool Tree::search(Vec origin, Vec way, const uint8_t* hidden, Hit& best) const {
    if (nodes_.empty()) return false;
    const auto inverse = [](float x) { return 1.0f / (std::fabs(x) > 1e-20f ? x : 1e-20f); };
    const float ix = inverse(way.x), iy = inverse(way.y), iz = inverse(way.z);
    const auto enter = [&](const Bounds& b) {
        const float x0 = (b.low.x - origin.x) * ix, x1 = (b.high.x - origin.x) * ix;
        const float y0 = (b.low.y - origin.y) * iy, y1 = (b.high.y - origin.y) * iy;
        const float z0 = (b.low.z - origin.z) * iz, z1 = (b.high.z - origin.z) * iz;
        const float first = larger(larger(smaller(x0, x1), smaller(y0, y1)), larger(smaller(z0, z1), 0.0f));
        const float last = smaller(smaller(larger(x0, x1), larger(y0, y1)), smaller(larger(z0, z1), best.distance));
        return first <= last ? first : -1.0f;
    };
    const Vecd from(origin), along(way);
    int stack[96], depth = 0, node = 0;
    bool found = false;
    if (enter(nodes_[0].box) < 0) return false;
    for (;;) {
        const Node& n = nodes_[node];
        if (n.count) {
            for (int i = n.first; i < n.first + n.count; ++i) {
                const Corners& corners = triangles_[i];
                const int t = corners.number;
                if (hidden && hidden[t]) continue;
                const Meeting m = meet(corners.a, corners.b, corners.c, from, along);
                const float distance = float(m.distance);
                if (any ? distance <= best.distance
                        : distance < best.distance || (distance == best.distance && t < best.triangle)) {
                    best = {t, distance, float(m.u), float(m.v)};
                    found = true;
                    if (any) return true;
                }
            }
        } else {
            const float left = enter(nodes_[n.first].box), right = enter(nodes_[n.first + 1].box);
            if (left >= 0 && right >= 0) {
                const bool left_first = left <= right;
                stack[depth++] = left_first ? n.first + 1 : n.first;
                node = left_first ? n.first : n.first + 1;
                continue;
            }
            if (left >= 0 || right >= 0) {
                node = left >= 0 ? n.first : n.first + 1;
                continue;
            }
        }
        if (depth == 0) return found;
        node = stack[--depth];
    }
}

bool Tree::closest(Vec origin, Vec way, const uint8_t* hidden, Hit& best) const {
    return search<false>(origin, way, hidden, best);
}

bool Tree::blocked(Vec origin, Vec way, float reach, const uint8_t* hidden) const {
    Hit best{-1, reach, 0, 0};
    return search<true>(origin, way, hidden, best);
}

}  // namespace ovman
