"""Light on what the rays hit: smooth normals, soft shadows, contact darkening, highlights, and the way to eight bits.

Everything is float32, in a fixed order and without fast-math, so a frame is a function of its inputs to the byte. The file is
self-contained on purpose: numba's cache watches the file of the compiled function alone.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numba import njit

REACH_M = 0.55
"""How far contact darkening looks."""
CURVE = 4096
"""Entries of the table from linear light to eight bits."""
BRIGHTEST = 4.0
"""Linear light that the table ends at."""


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
    """(16, 3) float32: directions about +z, spread as the cosine, for contact darkening."""
    k = np.arange(16)
    radius, angle = np.sqrt((k + 0.5) / 16), 2.399963229728653 * k
    around = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.sqrt(1 - radius**2)], axis=1)
    return np.round(around[(k * 7) % 16], 6).astype(np.float32)


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
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


@njit(cache=True)
def shadow_rays(
    prim, points, normals, width, height, wide, high, lights, samples, around, reach_m, starts, ways, reach, weight, at
):
    """Rays of the coarse grid (high x wide, every other pixel): one to a light from each point, then one for contact from each.

    starts, ways (2 H W, 3), reach (2 H W,) in lengths of the way; weight (H W,): what the light would bring; at (H W,): pixel.
    A point that sees nothing, and a light that shines the other way, get rays of no length.
    """
    total = wide * high
    for j in range(high):
        for i in range(wide):
            q = j * wide + i
            row, column = min(2 * j + 1, height - 1), min(2 * i + 1, width - 1)
            n = row * width + column
            at[q] = n
            weight[q] = np.float32(0)
            reach[q] = np.float32(0)
            reach[total + q] = np.float32(0)
            if prim[n] < 0:
                at[q] = -1
                for k in range(3):
                    starts[q, k], ways[q, k] = np.float32(1e6), np.float32(1)
                    starts[total + q, k], ways[total + q, k] = np.float32(1e6), np.float32(1)
                continue
            phase = (j & 3) * 4 + ((i + 2 * (j & 1)) & 3)
            nx, ny, nz = normals[n, 0], normals[n, 1], normals[n, 2]
            ox, oy, oz = (
                points[n, 0] + nx * np.float32(0.003),
                points[n, 1] + ny * np.float32(0.003),
                points[n, 2] + nz * np.float32(0.003),
            )
            light = np.int64(samples[phase, 4])
            lx, ly, lz = lights[light, 0] - ox, lights[light, 1] - oy, lights[light, 2] - oz
            square = lx * lx + ly * ly + lz * lz + lights[light, 9]
            inverse = np.float32(1) / np.sqrt(square)
            cosine = (lx * nx + ly * ny + lz * nz) * inverse
            shine = np.float32(1)
            if lights[light, 6] != 0 or lights[light, 7] != 0 or lights[light, 8] != 0:
                shine = -(lx * lights[light, 6] + ly * lights[light, 7] + lz * lights[light, 8]) * inverse
            starts[q, 0], starts[q, 1], starts[q, 2] = ox, oy, oz
            sx, sy, sz = samples[phase, 0] - ox, samples[phase, 1] - oy, samples[phase, 2] - oz
            far = np.sqrt(sx * sx + sy * sy + sz * sz)
            ways[q, 0], ways[q, 1], ways[q, 2] = sx, sy, sz
            if cosine > 0 and shine > 0:
                power = lights[light, 3] + lights[light, 4] + lights[light, 5]
                weight[q] = cosine * shine / square * power * samples[phase, 5]
                reach[q] = max(np.float32(1) - samples[phase, 3] / max(far, np.float32(1e-3)), np.float32(0))
            # a frame about the normal, without branches that would flip between neighbours
            sign = np.float32(1) if nz >= 0 else np.float32(-1)
            a = np.float32(-1) / (sign + nz)
            b = nx * ny * a
            dx, dy, dz = around[phase, 0], around[phase, 1], around[phase, 2]
            starts[total + q, 0], starts[total + q, 1], starts[total + q, 2] = ox, oy, oz
            ways[total + q, 0] = dx * (np.float32(1) + sign * nx * nx * a) + dy * b + dz * nx
            ways[total + q, 1] = dx * sign * b + dy * (sign + ny * ny * a) + dz * ny
            ways[total + q, 2] = -dx * sign * nx - dy * ny + dz * nz
            reach[total + q] = reach_m


@njit(cache=True)
def soften(blocked, weight, at, points, normals, distance, wide, high, lit, open_):
    """Shadow and contact of the coarse grid, averaged over the neighbours that lie on the same surface.

    lit (H W,): fraction of the light that arrives; open_ (H W,): fraction of the near surroundings that is free.
    """
    total = wide * high
    for j in range(high):
        for i in range(wide):
            q = j * wide + i
            n = at[q]
            lit[q], open_[q] = np.float32(1), np.float32(1)
            if n < 0:
                continue
            got, all_, free, count = np.float32(0), np.float32(0), np.float32(0), np.float32(0)
            slack = np.float32(0.01) + np.float32(0.01) * distance[n]
            for dj in range(-2, 3):
                y = j + dj
                if y < 0 or y >= high:
                    continue
                for di in range(-2, 3):
                    x = i + di
                    if x < 0 or x >= wide:
                        continue
                    p = y * wide + x
                    m = at[p]
                    if m < 0:
                        continue
                    alike = normals[n, 0] * normals[m, 0] + normals[n, 1] * normals[m, 1] + normals[n, 2] * normals[m, 2]
                    if alike < np.float32(0.85):
                        continue
                    off = (
                        (points[m, 0] - points[n, 0]) * normals[n, 0]
                        + (points[m, 1] - points[n, 1]) * normals[n, 1]
                        + (points[m, 2] - points[n, 2]) * normals[n, 2]
                    )
                    if abs(off) > slack:
                        continue
                    # each of the 16 phases has the same weight in a 5 x 5 window whose rim counts half
                    w = (np.float32(0.5) if abs(dj) == 2 else np.float32(1)) * (
                        np.float32(0.5) if abs(di) == 2 else np.float32(1)
                    )
                    all_ += w * weight[p]
                    if not blocked[p]:
                        got += w * weight[p]
                    count += w
                    if not blocked[total + p]:
                        free += w
            if all_ > 0:
                lit[q] = got / all_
            if count > 0:
                open_[q] = free / count


@njit(cache=True)
def shade(
    prim, points, normals, rays, origins, colour, columns, rows, coarse_at, lit, open_, coarse_points, coarse_normals, wide, high,
    tri_material, glosses, emissions, lights, ambient, exposure, sky, out,
):  # fmt: skip
    """Linear light (N, 3) float32 that N image points send to the eye.

    prim, points, normals, rays, origins, colour: of the points; columns, rows (N,): where they are in the image, pixels;
    coarse_*: the grid that `soften` filled, which indexes coarse_points and coarse_normals; lights (L, 10), ambient (3, 3) as in
    lights.Rig; sky (3,): what is seen where nothing is.
    """
    one, zero = np.float32(1), np.float32(0)
    for i in range(len(prim)):
        t = prim[i]
        if t < 0:
            out[i, 0], out[i, 1], out[i, 2] = sky[0], sky[1], sky[2]
            continue
        nx, ny, nz = normals[i, 0], normals[i, 1], normals[i, 2]
        px, py, pz = points[i, 0], points[i, 1], points[i, 2]
        # the four coarse points around, those on the same surface
        gx, gy = (columns[i] - np.float32(1.5)) * np.float32(0.5), (rows[i] - np.float32(1.5)) * np.float32(0.5)
        x0, y0 = np.int64(np.floor(gx)), np.int64(np.floor(gy))
        fx, fy = gx - np.float32(x0), gy - np.float32(y0)
        shadow, contact, total = zero, zero, zero
        for dj in range(2):
            y = min(max(y0 + dj, 0), high - 1)
            wy = fy if dj else one - fy
            for di in range(2):
                x = min(max(x0 + di, 0), wide - 1)
                q = y * wide + x
                m = coarse_at[q]
                if m < 0:
                    continue
                w = wy * (fx if di else one - fx) + np.float32(0.02)
                alike = nx * coarse_normals[m, 0] + ny * coarse_normals[m, 1] + nz * coarse_normals[m, 2]
                off = (coarse_points[m, 0] - px) * nx + (coarse_points[m, 1] - py) * ny + (coarse_points[m, 2] - pz) * nz
                if alike < np.float32(0.8) or abs(off) > np.float32(0.04):
                    w *= np.float32(1e-3)
                shadow += w * lit[q]
                contact += w * open_[q]
                total += w
        if total > 0:
            shadow, contact = shadow / total, contact / total
        else:
            shadow, contact = one, one
        m = tri_material[t]
        gloss = glosses[m]
        dx, dy, dz = rays[i, 0], rays[i, 1], rays[i, 2]
        inverse = one / np.sqrt(dx * dx + dy * dy + dz * dz)
        vx, vy, vz = -dx * inverse, -dy * inverse, -dz * inverse
        red, green, blue = zero, zero, zero
        shine_r, shine_g, shine_b = zero, zero, zero
        for k in range(len(lights)):
            lx, ly, lz = lights[k, 0] - px, lights[k, 1] - py, lights[k, 2] - pz
            near = one / np.sqrt(lx * lx + ly * ly + lz * lz + lights[k, 9])
            lx, ly, lz = lx * near, ly * near, lz * near
            cosine = lx * nx + ly * ny + lz * nz
            if cosine <= 0:
                continue
            beam = near * near
            if lights[k, 6] != 0 or lights[k, 7] != 0 or lights[k, 8] != 0:
                beam *= max(-(lx * lights[k, 6] + ly * lights[k, 7] + lz * lights[k, 8]), zero)
            red += lights[k, 3] * beam * cosine
            green += lights[k, 4] * beam * cosine
            blue += lights[k, 5] * beam * cosine
            if gloss > np.float32(0.05):
                hx, hy, hz = lx + vx, ly + vy, lz + vz
                s = (hx * nx + hy * ny + hz * nz) / np.sqrt(max(hx * hx + hy * hy + hz * hz, np.float32(1e-9)))
                s = max(s, zero)
                s = s * s
                s = s * s
                s = s * s
                s = s * s
                if gloss > np.float32(0.4):
                    s = s * s * s
                s *= gloss * gloss * beam * np.float32(0.9)
                shine_r += lights[k, 3] * s
                shine_g += lights[k, 4] * s
                shine_b += lights[k, 5] * s
        up = np.float32(0.5) + np.float32(0.5) * ny
        side = one - abs(ny)
        contact = np.float32(0.25) + np.float32(0.75) * contact
        a_r = (ambient[0, 0] * up + ambient[2, 0] * (one - up)) * (one - side) + ambient[1, 0] * side
        a_g = (ambient[0, 1] * up + ambient[2, 1] * (one - up)) * (one - side) + ambient[1, 1] * side
        a_b = (ambient[0, 2] * up + ambient[2, 2] * (one - up)) * (one - side) + ambient[1, 2] * side
        # a glossy skin mirrors the room's light at grazing angles
        rim = one - max(vx * nx + vy * ny + vz * nz, zero)
        rim = gloss * (np.float32(0.05) + np.float32(0.5) * rim * rim * rim * rim)
        bright = emissions[m] * np.float32(1.6)
        soft = shadow * (np.float32(0.55) + np.float32(0.45) * contact)
        out[i, 0] = (colour[i, 0] * (a_r * contact + red * soft) + shine_r * shadow + rim * a_r * contact) * exposure + colour[
            i, 0
        ] * bright
        out[i, 1] = (colour[i, 1] * (a_g * contact + green * soft) + shine_g * shadow + rim * a_g * contact) * exposure + colour[
            i, 1
        ] * bright
        out[i, 2] = (colour[i, 2] * (a_b * contact + blue * soft) + shine_b * shadow + rim * a_b * contact) * exposure + colour[
            i, 2
        ] * bright


@njit(cache=True)
def edges(ids, depth, normals, width, height, found):
    """Pixels where the picture breaks (another instance, another face, a step in depth) into found (H W,); returns how many.

    A pixel counts when it differs from its right or lower neighbour; both of the pair are taken.
    """
    marked = np.zeros(width * height, np.uint8)
    for y in range(height):
        for x in range(width):
            n = y * width + x
            for k in range(2):
                if (k == 0 and x + 1 >= width) or (k == 1 and y + 1 >= height):
                    continue
                m = n + 1 if k == 0 else n + width
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


@njit(cache=True)
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
