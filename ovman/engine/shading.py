"""Light on what the rays hit: smooth normals, soft shadows, contact darkening, highlights, and the way to eight bits.

Everything is float32, in a fixed order and without fast-math, so a frame is a function of its inputs to the byte. The file is
self-contained on purpose: numba's cache watches the file of the compiled function alone.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

PHASES = 9
"""Rays that a neighbourhood of 3 x 3 coarse points shares."""
REACH_M = 0.55
"""How far contact darkening looks."""
CURVE = 4096
"""Entries of the table from linear light to eight bits."""
BRIGHTEST = 4.0
"""Linear light that the table ends at."""
GRID = 15
"""Columns of the coarse grid: point, normal, light (RGB), its mean direction, lit, open, flat."""
LIFT_M = np.float32(0.004)
"""Rays from a surface start this far above it."""
CONTRAST = 0.2
"""Least relative difference of two neighbours for their edge to be worth smoothing."""


@cache
def curve() -> np.ndarray:
    """(4096,) float32: displayed value 0..255 of linear light 0..4: a soft shoulder, then the sRGB curve."""
    light = np.linspace(0, BRIGHTEST, CURVE)
    knee = 0.55
    light = np.where(light < knee, light, knee + (1 - knee) * (1 - np.exp(-(light - knee) / (1 - knee))))
    shown = np.where(light <= 0.0031308, 12.92 * light, 1.055 * np.maximum(light, 1e-9) ** (1 / 2.4) - 0.055)
    return np.round(np.clip(shown, 0, 1) * 255, 3).astype(np.float32)


@cache
def directions() -> np.ndarray:
    """(PHASES, 3) float32: directions about +z, spread as the cosine, for contact darkening."""
    k = np.arange(PHASES)
    radius, angle = np.sqrt((k + 0.5) / PHASES), 2.399963229728653 * k
    around = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)], axis=1)
    return np.round(around[(k * 4) % PHASES], 6).astype(np.float32)


@njit(cache=True, error_model="numpy")
def primary(right, up, forward, tan_x, tan_y, eye, near, flat, columns, rows, width, height, origins, rays):
    """Rays through N image points into origins and rays (N, 3) float32.

    columns, rows (N,) float32: image points in pixels, row 0 at the top, centres at +0.5. A ray's length along `forward` is 1, so
    distances along it are planar depths beyond `near`, where it starts. `flat`: all rays parallel (orthographic), and tan_x,
    tan_y are half the width and height of the picture in metres.
    """
    for i in range(len(columns)):
        x = (np.float32(2) * columns[i] / np.float32(width) - np.float32(1)) * tan_x
        y = (np.float32(1) - np.float32(2) * rows[i] / np.float32(height)) * tan_y
        for a in range(3):
            aside = right[a] * x + up[a] * y
            rays[i, a] = forward[a] if flat else aside + forward[a]
            origins[i, a] = eye[a] + near * rays[i, a] + (aside if flat else np.float32(0))


@njit(cache=True, error_model="numpy")
def identify(prim, distance, instance, near, far, ids, depth):
    """Instance ids (N,) int32 (-1: nothing) and planar depth (N,) float32 metres (`far`: nothing) of N hits."""
    span = far - near
    for i in range(len(prim)):
        if prim[i] >= 0 and distance[i] <= span:
            ids[i] = instance[prim[i]]
            depth[i] = distance[i] + near
        else:
            ids[i] = -1
            depth[i] = far


@njit(cache=True, error_model="numpy")
def surface(prim, u, v, distance, origins, rays, tri_normals, pixel, flat, points, normals, footprint):
    """Points (N, 3), unit normals (N, 3) towards the viewer and pixel footprints (N,) metres of N hits.

    `pixel`: width of a pixel one metre away, metres (everywhere, if the picture is orthographic: `flat`).
    """
    for i in range(len(prim)):
        t = prim[i]
        if t < 0:
            continue
        d = distance[i]
        a, b = u[i], v[i]
        c = np.float32(1) - a - b
        dx, dy, dz = rays[i, 0], rays[i, 1], rays[i, 2]
        x = c * tri_normals[t, 0, 0] + a * tri_normals[t, 1, 0] + b * tri_normals[t, 2, 0]
        y = c * tri_normals[t, 0, 1] + a * tri_normals[t, 1, 1] + b * tri_normals[t, 2, 1]
        z = c * tri_normals[t, 0, 2] + a * tri_normals[t, 1, 2] + b * tri_normals[t, 2, 2]
        facing = x * dx + y * dy + z * dz
        size = x * x + y * y + z * z
        scale = np.float32(1) / np.sqrt(max(size, np.float32(1e-12)))
        if facing > 0:
            scale = -scale
        normals[i, 0], normals[i, 1], normals[i, 2] = x * scale, y * scale, z * scale
        length = np.sqrt(dx * dx + dy * dy + dz * dz)
        grazing = max(abs(facing * scale) / length, np.float32(0.2))
        footprint[i] = pixel / grazing if flat else pixel * d * length / grazing
        for k in range(3):
            points[i, k] = origins[i, k] + d * rays[i, k]


@njit(cache=True, error_model="numpy", inline="always")
def _sum_lights(lights, px, py, pz, nx, ny, nz):
    """Unshadowed light on a point: (red, green, blue) and its mean direction (x, y, z), not normalised."""
    zero = np.float32(0)
    red, green, blue, tx, ty, tz = zero, zero, zero, zero, zero, zero
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
    return red, green, blue, tx, ty, tz


@njit(cache=True, error_model="numpy")
def coarse(
    prim, points, normals, width, height, wide, high, lights, shadowed, samples, around, reach_m,
    starts, ways, reach, slots, weight, even, grid,
):  # fmt: skip
    """Light and rays of the coarse grid (high x wide: every other pixel). Returns how many rays there are.

    grid (H W, GRID) float32 gets point, normal, light and its direction of each coarse point; a normal of 0 where nothing is.
    Rays go from each point to one of the first `shadowed` lights, if it shines there, and from every other point, as on the black
    squares of a board, to what is near: starts, ways (2 H W, 3), reach (2 H W,) in lengths of the way. slots (H W, 2): the numbers
    of a point's two rays, -1 for none. weight (H W,): what the one light would bring; even (H W,): what the lights without shadows
    bring.
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
            grid[q, 6], grid[q, 7], grid[q, 8], grid[q, 9], grid[q, 10], grid[q, 11] = _sum_lights(lights, px, py, pz, nx, ny, nz)
            if shadowed < len(lights):
                red, green, blue, _, _, _ = _sum_lights(lights[shadowed:], px, py, pz, nx, ny, nz)
                even[q] = (red + green + blue) * np.float32(1 / PHASES)
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
            if (i + j) & 1 == 0:
                # a frame about the normal that has no seam where a coordinate changes its sign but one
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
    """Whether two coarse points lie on one surface: similar normals, and q at most `slack` off the plane of p."""
    if grid[p, 3] * grid[q, 3] + grid[p, 4] * grid[q, 4] + grid[p, 5] * grid[q, 5] < np.float32(0.5):
        return False
    off = (grid[q, 0] - grid[p, 0]) * grid[p, 3] + (grid[q, 1] - grid[p, 1]) * grid[p, 4] + (grid[q, 2] - grid[p, 2]) * grid[p, 5]
    return abs(off) <= slack


@njit(cache=True, error_model="numpy")
def soften(blocked, slots, weight, even, grid, eye, wide, high):
    """Writes lit and open of the grid: the fraction of the light that arrives and of the near surroundings that is free, averaged
    over those of its neighbours that lie on the same surface; dims the light by it. Then marks as `flat` the cells, from each
    point to the next one right and down, whose four corners lie on one plane.

    Neighbours weigh 1 2 3 2 1 along rows, then along columns: every one of the 3 x 3 phases counts the same everywhere, and what
    one phase sees is interpolated linearly between the points that have it.
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
            # a point with few of its kind around has seen too few directions to be called dark
            grid[q, 13] = (free + np.float32(4)) / (count + np.float32(6))
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
    """Linear light (N, 3) float32 that N image points send to the eye.

    prim, points, normals, rays, colour: of the points; columns, rows (N,): where they are in the image, pixels; grid, wide, high:
    as `soften` left it; lights (L, 11), ambient (3, 3) as in lights.Rig; sky (3,): what is seen where nothing is.
    The light of a point is that of the coarse points around it on the same surface, turned to its own normal; a point that has
    none, or that is turned far, gets its own light in their shadow.
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
                red, green, blue, tx, ty, tz = _sum_lights(lights, px, py, pz, nx, ny, nz)
                red, green, blue = red * shadow, green * shadow, blue * shadow
        up = np.float32(0.5) + np.float32(0.5) * ny
        side = one - abs(ny)
        contact = np.float32(0.25) + np.float32(0.75) * contact
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
            # a glossy skin mirrors the room's light at grazing angles
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


@njit(cache=True, error_model="numpy")
def edges(ids, depth, normals, linear, width, height, found):
    """Pixels where the picture breaks (another instance, another face, a step in depth) and one sees it, into found (H W,);
    returns how many. A pixel counts when it differs from its right or lower neighbour; both of the pair are taken."""
    marked = np.zeros(width * height, np.uint8)
    least = np.float32(CONTRAST)
    for y in range(height):
        for x in range(width):
            n = y * width + x
            for k in range(2):
                if (k == 0 and x + 1 >= width) or (k == 1 and y + 1 >= height):
                    continue
                m = n + 1 if k == 0 else n + width
                unlike = abs(linear[n, 0] - linear[m, 0]) + abs(linear[n, 1] - linear[m, 1]) + abs(linear[n, 2] - linear[m, 2])
                if unlike < least * (linear[n, 0] + linear[n, 1] + linear[n, 2] + least):
                    continue
                breaks = ids[n] != ids[m]
                if not breaks and ids[n] >= 0:
                    step = abs(depth[n] - depth[m])
                    alike = normals[n, 0] * normals[m, 0] + normals[n, 1] * normals[m, 1] + normals[n, 2] * normals[m, 2]
                    breaks = alike < np.float32(0.8) or step > np.float32(0.06) * min(depth[n], depth[m])
                if breaks:
                    marked[n], marked[m] = 1, 1
    count = 0
    for n in range(width * height):
        if marked[n]:
            found[count] = n
            count += 1
    return count


@njit(cache=True, error_model="numpy")
def develop(linear, table, extra, pixels, per_pixel, out):
    """Eight-bit picture (N, 3) uint8 of linear light (N, 3). `extra` (len(pixels) * per_pixel, 3): further samples of `pixels`,
    which are averaged with the first one as they are shown, not as light, so that bright edges stay smooth."""
    scale = np.float32((CURVE - 1) / BRIGHTEST)
    last = np.float32(CURVE - 1)
    for i in range(len(linear)):
        for k in range(3):
            x = min(max(linear[i, k] * scale, np.float32(0)), last)
            out[i, k] = np.uint8(table[np.int64(x)] + np.float32(0.5))
    for j in range(len(pixels)):
        n = pixels[j]
        for k in range(3):
            x = min(max(linear[n, k] * scale, np.float32(0)), last)
            total = table[np.int64(x)]
            for s in range(per_pixel):
                x = min(max(extra[j * per_pixel + s, k] * scale, np.float32(0)), last)
                total += table[np.int64(x)]
            out[n, k] = np.uint8(total / np.float32(per_pixel + 1) + np.float32(0.5))
