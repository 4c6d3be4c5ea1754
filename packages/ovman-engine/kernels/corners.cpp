#include "corners.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

#include "geometry.hpp"

namespace ovman {
namespace {

constexpr double GRAIN_M = 1e-5;  // coordinates that are equal to this precision are one point

// A number for each vertex that is equal for vertices of one part at one place; returns how many there are.
int number_places(const double* vertices, const std::vector<int32_t>& part, std::vector<int>& places) {
    std::vector<uint64_t> keys(part.size());
    for (size_t i = 0; i < part.size(); ++i) {
        uint64_t key = uint64_t(part[i]) * 0xD6E8FEB86659FD93u;
        for (int k = 0; k < 3; ++k) {
            key ^= uint64_t(int64_t(std::nearbyint(vertices[3 * i + k] / GRAIN_M)));
            key *= 0x9E3779B97F4A7C15u;
            key ^= key >> 29;
        }
        keys[i] = key;
    }
    std::vector<int> order(part.size());
    std::iota(order.begin(), order.end(), 0);
    std::sort(order.begin(), order.end(), [&](int a, int b) { return keys[a] < keys[b]; });
    places.resize(part.size());
    int count = -1;
    for (size_t j = 0; j < order.size(); ++j) {
        if (j == 0 || keys[order[j]] != keys[order[j - 1]]) ++count;
        places[order[j]] = count;
    }
    return count + 1;
}

}  // namespace

void corner_normals(const double* vertices, int vertex_count, const int32_t* triangles, const int32_t* part, int count,
                    const double* turns, double cosine, double* normals, int32_t* axis) {
    std::vector<Vecd> area(count), own(count);
    std::vector<int32_t> part_of_vertex(vertex_count, 0);
    const auto at = [&](int v) { return Vecd(vertices[3 * v], vertices[3 * v + 1], vertices[3 * v + 2]); };
    for (int t = 0; t < count; ++t) {
        const int32_t* corner = triangles + 3 * t;
        for (int k = 0; k < 3; ++k) part_of_vertex[corner[k]] = part[t];
        area[t] = cross(at(corner[1]) - at(corner[0]), at(corner[2]) - at(corner[0]));
        const double size = std::sqrt(dot(area[t], area[t]));
        own[t] = {area[t].x / (size > 0 ? size : 1), area[t].y / (size > 0 ? size : 1), area[t].z / (size > 0 ? size : 1)};
        double most = -1;
        for (int k = 0; k < 3; ++k) {
            const double* turn = turns + 9 * part[t] + k;
            const double along = std::fabs(own[t].x * turn[0] + own[t].y * turn[3] + own[t].z * turn[6]);
            if (along > most + 1e-9) most = along, axis[t] = k;
        }
    }
    std::vector<int> places;
    const int place_count = number_places(vertices, part_of_vertex, places);
    std::vector<int> starts(place_count + 1, 0), faces(3 * size_t(count));
    for (int i = 0; i < 3 * count; ++i) ++starts[places[triangles[i]] + 1];
    for (int p = 0; p < place_count; ++p) starts[p + 1] += starts[p];
    std::vector<int> filled(starts.begin(), starts.end() - 1);
    for (int i = 0; i < 3 * count; ++i) faces[filled[places[triangles[i]]]++] = i / 3;
    for (int i = 0; i < 3 * count; ++i) {
        const int p = places[triangles[i]], t = i / 3;
        Vecd sum;
        for (int j = starts[p]; j < starts[p + 1]; ++j)
            if (dot(own[t], own[faces[j]]) > cosine) sum = sum + area[faces[j]];
        const double size = std::sqrt(dot(sum, sum));
        const Vecd normal = size > 0 ? Vecd(sum.x / size, sum.y / size, sum.z / size) : own[t];
        normals[3 * i] = normal.x, normals[3 * i + 1] = normal.y, normals[3 * i + 2] = normal.z;
    }
}

}  // namespace ovman
