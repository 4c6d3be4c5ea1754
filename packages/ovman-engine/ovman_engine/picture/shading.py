"""Light on the hits of a view: soft shadows, contact darkening, highlights.

All numbers are float32, in a fixed order and without fast-math, so a frame is a function of its inputs to the byte. This file
imports no other kernel: numba's cache watches the file of the compiled function only.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

PHASES = 9
"""Number of rays that a neighbourhood of 3 x 3 coarse points shares."""
REACH_M = 0.55
"""Range of contact darkening."""
GRID = 15
"""Columns of the coarse grid: point, normal, light (RGB), its mean direction, lit, open, flat."""
LIFT_M = np.float32(0.004)
"""Rays from a surface start this far above it."""


@cache
def directions() -> np.ndarray:
    """(PHASES, 3) float32: directions about +z, distributed as the cosine, for contact darkening."""
    k = np.arange(PHASES)
    radius, angle = np.sqrt((k + 0.5) / PHASES), 2.399963229728653 * k
    around = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)], axis=1)
    return np.round(around[(k * 4) % PHASES], 6).astype(np.float32)


@njit(cache=True, error_model="numpy", inline="always")
def _sum_lights(lights, shadowed, px, py, pz, nx, ny, nz):
    """Unshadowed light at a point: red, green, blue.

    Its mean direction x, y, z, not normalised; and the sum of the colours of all lights from number `shadowed` on.
    """
    zero = np.float32(0)
    red, green, blue, tx, ty, tz, even = zero, zero, zero, zero, zero, zero, zero
    for k in range(len(lights)):
        lx, ly, lz = lights[k, 0] - px, lights[k, 1] - py, lights[k, 2] - pz
        cosine = lx * nx + ly * ny + lz * nz
        if cosine <= 0:
            continue
        shine = np.float32(1)
        near = np.float32(1) / np.sqrt(lx * lx + ly * ly + lz * lz + lights[k, 9])
        if lights[k, 10] > 0:
            shine = -(lx * lights[k, 6] + ly * lights[k, 7] + lz * lights[k, 8]) * near
            if shine <= 0:
                continue
        beam = shine * near * near * near
        bright = beam * cosine
        red += lights[k, 3] * bright
        green += lights[k, 4] * bright
        blue += lights[k, 5] * bright
        power = beam * (lights[k, 3] + lights[k, 4] + lights[k, 5])
        tx += lx * power
        ty += ly * power
        tz += lz * power
        if k >= shadowed:
            even += power * cosine
    return red, green, blue, tx, ty, tz, even


@njit(cache=True, error_model="numpy")
def coarse(
    prim, points, normals, width, height, wide, high, lights, shadowed, samples, around, reach_m,
    starts, ways, reach, slots, weight, even, grid,
):  # fmt: skip
    """Light and shadow rays of the coarse grid (high x wide: every other pixel). Returns the number of rays.

    grid (H W, GRID) float32 receives point, normal, light and its direction of each coarse point; a normal of 0 without a hit.
    Each point has one ray to its surroundings, and one to one of the first `shadowed` lights if that shines there: starts, ways
    (2 H W, 3), reach (2 H W,) in lengths of the way. slots (H W, 2): numbers of a point's rays to the light and to its
    surroundings, -1 for none. weight (H W,): light of that one lamp; even (H W,): light of the lamps without shadows.
    """
    rays = 0
    for j in range(high):
        for i in range(wide):
            q = j * wide + i
            n = min(2 * j + 1, height - 1) * width + min(2 * i + 1, width - 1)
            weight[q], even[q], slots[q, 0], slots[q, 1] = np.float32(0), np.float32(0), -1, -1
            if prim[n] < 0:
                for k in range(GRID):
                    grid[q, k] = np.float32(0)
                continue
            phase = (j % 3) * 3 + i % 3
            px, py, pz = points[n, 0], points[n, 1], points[n, 2]
            nx, ny, nz = normals[n, 0], normals[n, 1], normals[n, 2]
            grid[q, 0], grid[q, 1], grid[q, 2] = px, py, pz
            grid[q, 3], grid[q, 4], grid[q, 5] = nx, ny, nz
            red, green, blue, tx, ty, tz, free = _sum_lights(lights, shadowed, px, py, pz, nx, ny, nz)
            grid[q, 6], grid[q, 7], grid[q, 8], grid[q, 9], grid[q, 10], grid[q, 11] = red, green, blue, tx, ty, tz
            even[q] = free * np.float32(1 / PHASES)
            ox, oy, oz = px + nx * LIFT_M, py + ny * LIFT_M, pz + nz * LIFT_M
            light = np.int64(samples[phase, 4])
            lx, ly, lz = lights[light, 0] - px, lights[light, 1] - py, lights[light, 2] - pz
            inverse = np.float32(1) / np.sqrt(lx * lx + ly * ly + lz * lz + lights[light, 9])
            cosine = (lx * nx + ly * ny + lz * nz) * inverse
            shine = np.float32(1)
            if lights[light, 10] > 0:
                shine = -(lx * lights[light, 6] + ly * lights[light, 7] + lz * lights[light, 8]) * inverse
            if cosine > 0 and shine > 0:
                power = lights[light, 3] + lights[light, 4] + lights[light, 5]
                weight[q] = cosine * shine * inverse * inverse * power * samples[phase, 5]
                sx, sy, sz = samples[phase, 0] - ox, samples[phase, 1] - oy, samples[phase, 2] - oz
                far = np.sqrt(sx * sx + sy * sy + sz * sz)
                starts[rays, 0], starts[rays, 1], starts[rays, 2] = ox, oy, oz
                ways[rays, 0], ways[rays, 1], ways[rays, 2] = sx, sy, sz
                reach[rays] = max(np.float32(1) - samples[phase, 3] / max(far, np.float32(1e-3)), np.float32(0))
                slots[q, 0] = rays
                rays += 1
            # a frame about the normal, continuous except at one sign change of a coordinate
            sign = np.float32(1) if nz >= 0 else np.float32(-1)
            a = np.float32(-1) / (sign + nz)
            b = nx * ny * a
            dx, dy, dz = around[phase, 0], around[phase, 1], around[phase, 2]
            starts[rays, 0], starts[rays, 1], starts[rays, 2] = ox, oy, oz
            ways[rays, 0] = dx * (np.float32(1) + sign * nx * nx * a) + dy * b + dz * nx
            ways[rays, 1] = dx * sign * b + dy * (sign + ny * ny * a) + dz * ny
            ways[rays, 2] = -dx * sign * nx - dy * ny + dz * nz
            reach[rays] = reach_m
            slots[q, 1] = rays
            rays += 1
    return rays


@njit(cache=True, error_model="numpy", inline="always")
def _alike(grid, p, q, slack):
    """Whether two coarse points are on one surface: similar normals, and q at most `slack` off the plane of p."""
    if grid[p, 3] * grid[q, 3] + grid[p, 4] * grid[q, 4] + grid[p, 5] * grid[q, 5] < np.float32(0.5):
        return False
    off = (grid[q, 0] - grid[p, 0]) * grid[p, 3] + (grid[q, 1] - grid[p, 1]) * grid[p, 4] + (grid[q, 2] - grid[p, 2]) * grid[p, 5]
    return abs(off) <= slack


@njit(cache=True, error_model="numpy")
def soften(blocked, slots, weight, even, grid, eye, wide, high):
    """Write lit and open of the grid, averaged over neighbours on the same surface, and dim the light by them.

    They are the fractions of arriving light and of free surroundings. Then mark as `flat` the cells, from each point to the next
    one right and down, whose four corners are on one plane.

    Neighbours weigh 1 2 3 2 1 along rows, then along columns: each of the 3 x 3 phases counts the same everywhere, and what one
    phase sees is interpolated linearly between its points.
    """
    total = wide * high
    sums = np.zeros((total, 4), np.float32)
    slack = np.empty(total, np.float32)
    for j in range(high):
        for i in range(wide):
            q = j * wide + i
            away = abs(grid[q, 0] - eye[0]) + abs(grid[q, 1] - eye[1]) + abs(grid[q, 2] - eye[2])
            slack[q] = np.float32(0.03) + np.float32(0.01) * away
            got, whole, free, count = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            for p in range(q - min(i, 2), q + min(wide - i, 3)):
                if p != q and not _alike(grid, q, p, slack[q]):
                    continue
                w = np.float32(3 - abs(p - q))
                whole += w * (weight[p] + even[p])
                got += w * even[p]
                if slots[p, 0] >= 0 and not blocked[slots[p, 0]]:
                    got += w * weight[p]
                if slots[p, 1] >= 0:
                    count += w
                    if not blocked[slots[p, 1]]:
                        free += w
            sums[q, 0], sums[q, 1], sums[q, 2], sums[q, 3] = got, whole, free, count
    for j in range(high):
        for i in range(wide):
            q = j * wide + i
            got, whole, free, count = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            for k in range(max(-2, -j), min(3, high - j)):
                p = q + k * wide
                if k != 0 and not _alike(grid, q, p, slack[q]):
                    continue
                w = np.float32(3 - abs(k))
                got += w * sums[p, 0]
                whole += w * sums[p, 1]
                free += w * sums[p, 2]
                count += w * sums[p, 3]
            grid[q, 12] = got / whole if whole > 0 else np.float32(1)
            # a point with few neighbours on its surface has seen too few directions to be called dark
            grid[q, 13] = (free + np.float32(7)) / (count + np.float32(10))
    for q in range(total):
        for k in range(6, 9):
            grid[q, k] *= grid[q, 12]
    for j in range(high):
        for i in range(wide):
            q = j * wide + i
            flat = i + 1 < wide and j + 1 < high
            if flat:
                nx, ny, nz = grid[q, 3], grid[q, 4], grid[q, 5]
                for k in range(1, 4):
                    p = q + (k & 1) + wide * (k >> 1)
                    if nx * grid[p, 3] + ny * grid[p, 4] + nz * grid[p, 5] < np.float32(0.9999):
                        flat = False
                    off = (grid[p, 0] - grid[q, 0]) * nx + (grid[p, 1] - grid[q, 1]) * ny + (grid[p, 2] - grid[q, 2]) * nz
                    if abs(off) > np.float32(0.004):
                        flat = False
            grid[q, 14] = np.float32(1) if flat else np.float32(0)


@njit(cache=True, error_model="numpy")
def shade(prim, points, normals, rays, colour, columns, rows, grid, wide, high, tri_material, glosses, emissions, lights, ambient,
          exposure, sky, out):  # fmt: skip
    """Write the linear light (N, 3) float32 that N image points send to the eye.

    prim, points, normals, rays, colour: of the points; columns, rows (N,): their place in the image, pixels; grid, wide, high: as
    `soften` left them; lights (L, 11) and ambient (3, 3) as in lights.Rig; sky (3,): colour without a hit. A point takes its
    light from the coarse points around it on the same surface, turned to its own normal. Without such a point, or with a very
    different normal, it gets its own light in their shadow.
    """
    one, zero = np.float32(1), np.float32(0)
    for i in range(len(prim)):
        t = prim[i]
        if t < 0:
            out[i, 0], out[i, 1], out[i, 2] = sky[0], sky[1], sky[2]
            continue
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        gx, gy = (columns[i] - np.float32(1.5)) * np.float32(0.5), (rows[i] - np.float32(1.5)) * np.float32(0.5)
        x0, y0 = np.int64(np.floor(gx)), np.int64(np.floor(gy))
        fx, fy = gx - np.float32(x0), gy - np.float32(y0)
        m = tri_material[t]
        gloss = glosses[m]
        q = max(y0, 0) * wide + max(x0, 0)
        tx, ty, tz = zero, zero, zero
        if (
            grid[q, 14] > 0
            and nx * grid[q, 3] + ny * grid[q, 4] + nz * grid[q, 5] > np.float32(0.9999)
            and abs((grid[q, 0] - px) * nx + (grid[q, 1] - py) * ny + (grid[q, 2] - pz) * nz) < np.float32(0.004)
        ):
            if x0 < 0:
                fx = zero
            if y0 < 0:
                fy = zero
            w0, w1, w2, w3 = (one - fx) * (one - fy), fx * (one - fy), (one - fx) * fy, fx * fy
            q2 = q + wide
            red = w0 * grid[q, 6] + w1 * grid[q + 1, 6] + w2 * grid[q2, 6] + w3 * grid[q2 + 1, 6]
            green = w0 * grid[q, 7] + w1 * grid[q + 1, 7] + w2 * grid[q2, 7] + w3 * grid[q2 + 1, 7]
            blue = w0 * grid[q, 8] + w1 * grid[q + 1, 8] + w2 * grid[q2, 8] + w3 * grid[q2 + 1, 8]
            contact = w0 * grid[q, 13] + w1 * grid[q + 1, 13] + w2 * grid[q2, 13] + w3 * grid[q2 + 1, 13]
            if gloss > np.float32(0.1):
                tx = w0 * grid[q, 9] + w1 * grid[q + 1, 9] + w2 * grid[q2, 9] + w3 * grid[q2 + 1, 9]
                ty = w0 * grid[q, 10] + w1 * grid[q + 1, 10] + w2 * grid[q2, 10] + w3 * grid[q2 + 1, 10]
                tz = w0 * grid[q, 11] + w1 * grid[q + 1, 11] + w2 * grid[q2, 11] + w3 * grid[q2 + 1, 11]
        else:
            shadow, contact, total, any_shadow, any_contact = zero, zero, zero, zero, zero
            red, green, blue, cx, cy, cz = zero, zero, zero, zero, zero, zero
            for dj in range(2):
                y = min(max(y0 + dj, 0), high - 1)
                wy = fy if dj else one - fy
                for di in range(2):
                    x = min(max(x0 + di, 0), wide - 1)
                    q = y * wide + x
                    any_shadow += np.float32(0.25) * grid[q, 12]
                    any_contact += np.float32(0.25) * grid[q, 13]
                    mx, my, mz = grid[q, 3], grid[q, 4], grid[q, 5]
                    if nx * mx + ny * my + nz * mz < np.float32(0.6):
                        continue
                    if abs((grid[q, 0] - px) * nx + (grid[q, 1] - py) * ny + (grid[q, 2] - pz) * nz) > np.float32(0.04):
                        continue
                    w = wy * (fx if di else one - fx) + np.float32(0.02)
                    total += w
                    shadow += w * grid[q, 12]
                    contact += w * grid[q, 13]
                    red += w * grid[q, 6]
                    green += w * grid[q, 7]
                    blue += w * grid[q, 8]
                    tx += w * grid[q, 9]
                    ty += w * grid[q, 10]
                    tz += w * grid[q, 11]
                    cx += w * mx
                    cy += w * my
                    cz += w * mz
            turned = False
            if total > 0:
                total = one / total
                shadow, contact = shadow * total, contact * total
                had = (tx * cx + ty * cy + tz * cz) * total
                has = tx * nx + ty * ny + tz * nz
                turned = has > np.float32(0.6) * had and has < np.float32(1.5) * had
                if turned:
                    turn = total * has / had
                    red, green, blue = red * turn, green * turn, blue * turn
            else:
                shadow, contact = any_shadow, any_contact
            if not turned:
                red, green, blue, tx, ty, tz, _ = _sum_lights(lights, len(lights), px, py, pz, nx, ny, nz)
                red, green, blue = red * shadow, green * shadow, blue * shadow
        up = np.float32(0.5) + np.float32(0.5) * ny
        side = one - abs(ny)
        contact = np.float32(0.4) + np.float32(0.6) * contact
        above, below = up * (one - side) * contact, (one - up) * (one - side) * contact
        side *= contact
        a_r = ambient[0, 0] * above + ambient[1, 0] * side + ambient[2, 0] * below
        a_g = ambient[0, 1] * above + ambient[1, 1] * side + ambient[2, 1] * below
        a_b = ambient[0, 2] * above + ambient[1, 2] * side + ambient[2, 2] * below
        direct = np.float32(0.55) + np.float32(0.45) * contact
        bright = emissions[m] * np.float32(1.6) / exposure
        r = colour[i, 0] * (a_r + red * direct + bright)
        g = colour[i, 1] * (a_g + green * direct + bright)
        b = colour[i, 2] * (a_b + blue * direct + bright)
        gloss -= np.float32(0.1)
        if gloss > 0:
            dx, dy, dz = rays[i, 0], rays[i, 1], rays[i, 2]
            inverse = one / np.sqrt(dx * dx + dy * dy + dz * dz)
            vx, vy, vz = -dx * inverse, -dy * inverse, -dz * inverse
            # a glossy surface reflects the room's light at grazing angles
            rim = one - max(vx * nx + vy * ny + vz * nz, zero)
            rim = gloss * (np.float32(0.04) + np.float32(0.4) * rim * rim * rim * rim)
            strength = tx * tx + ty * ty + tz * tz
            if strength > 0:
                inverse = one / np.sqrt(strength)
                hx, hy, hz = tx * inverse + vx, ty * inverse + vy, tz * inverse + vz
                s = max(hx * nx + hy * ny + hz * nz, zero) / np.sqrt(max(hx * hx + hy * hy + hz * hz, np.float32(1e-9)))
                s *= s
                s *= s
                s *= s
                s *= s
                if gloss > np.float32(0.3):
                    s *= s * s
                s *= gloss * gloss * np.float32(1.2)
                r += s * red
                g += s * green
                b += s * blue
            r += rim * (a_r + np.float32(0.5) * red)
            g += rim * (a_g + np.float32(0.5) * green)
            b += rim * (a_b + np.float32(0.5) * blue)
        out[i, 0], out[i, 1], out[i, 2] = r * exposure, g * exposure, b * exposure
