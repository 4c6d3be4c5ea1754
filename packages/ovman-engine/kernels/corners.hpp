// Normals at the corners of triangles: smooth where faces meet at a small angle, sharp elsewhere.
#pragma once

#include <cstdint>

namespace ovman {

// Writes unit normals (T, 3, 3) and, as axis (T,), the axis of its part that each triangle faces most. See corners.of_parts.
void corner_normals(const double* vertices, int vertex_count, const int32_t* triangles, const int32_t* part, int count,
                    const double* turns, double cosine, double* normals, int32_t* axis);

}  // namespace ovman
