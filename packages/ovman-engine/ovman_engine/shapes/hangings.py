"""Objects on walls: windows, blinds, curtains, mirrors, pictures. They face +z; the wall is at -z."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, rod, span
from ovman_engine.shapes.subject import Subject


def _frame(s: Subject, width: float, back: float, front: float, slot: str, bevel: float = 0.006) -> Iterator[Part]:
    for sx in (-1, 1):
        low, high = sorted((sx * s.x, sx * (s.x - width)))
        yield span((low, 0, back), (high, s.h, front), slot, bevel=bevel, solid=False)
    for low, high in ((0.0, width), (s.h - width, s.h)):
        yield span((-s.x + width, low, back), (s.x - width, high, front), slot, bevel=bevel, solid=False)


def window(s: Subject) -> Iterator[Part]:
    """Frame, sashes, panes with the sky behind them, glazing bars and a sill."""
    st = s.style
    casing = min(st.uniform("casing", 0.045, 0.08), 0.14 * s.w, 0.14 * s.h)
    deep = min(0.5 * s.d, 0.05)
    back = -s.z
    front = s.z - min(0.02, 0.3 * s.d)
    yield span((-s.x, 0, back), (s.x, s.h, back + deep), drawn=False)
    yield span(
        (-s.x + 0.4 * casing, 0.4 * casing, back), (s.x - 0.4 * casing, s.h - 0.4 * casing, back + 0.3 * deep), "sky", solid=False
    )
    yield from _frame(s, casing, back, front, "trim")
    columns = max(1, round(s.w / st.uniform("pane width", 0.5, 0.8)))
    rows = max(1, round(s.h / st.uniform("pane height", 0.5, 0.9)))
    bar_m = 0.022
    inside = (-s.x + casing, s.x - casing, casing, s.h - casing)
    z0, z1 = back + 0.3 * deep, min(front, back + deep)
    for i in range(1, columns):
        x = inside[0] + (inside[1] - inside[0]) * i / columns
        wide = bar_m * (1.8 if columns == 2 else 1.0)
        yield span((x - wide / 2, inside[2], z0), (x + wide / 2, inside[3], z1), "trim", solid=False)
    for i in range(1, rows):
        y = inside[2] + (inside[3] - inside[2]) * i / rows
        yield span((inside[0], y - bar_m / 2, z0), (inside[1], y + bar_m / 2, z1), "trim", solid=False)
    yield span((-s.x, 0, back), (s.x, 0.6 * casing, s.z), "trim", bevel=0.004, solid=False)


def blinds(s: Subject) -> Iterator[Part]:
    """Yield a head rail and slats; raised blinds show a packed stack."""
    head = min(0.06, 0.3 * s.h)
    yield span((-s.x, s.h - head, -s.z), (s.x, s.h, s.z), "main", bevel=0.004)
    pitch = 0.022 if s.h > 0.4 else 0.012
    count = max(3, int((s.h - head - 0.02) / pitch))
    for i in range(count):
        y = 0.02 + (s.h - head - 0.03) * (i + 0.5) / count
        yield Part("box", (0, y, 0), (s.w * 0.995, 0.0022, 0.8 * s.d), about("x", 24.0), "second", solid=False)
    yield span((-s.x, 0, -0.6 * s.z), (s.x, 0.018, 0.6 * s.z), "main", bevel=0.003, solid=False)
    for x in (-0.7 * s.x, 0.7 * s.x):
        yield rod((x, 0.01, 0.2 * s.z), (x, s.h - head, 0.2 * s.z), 0.0015, "trim", solid=False)


def curtains(s: Subject) -> Iterator[Part]:
    """Folds below a rail; two halves drawn aside where it is wide. They run along the longer side."""
    along_x = s.along_x
    half, deep = (s.x, s.z) if along_x else (s.z, s.x)
    top = s.h - min(0.05, 0.05 * s.h)

    def at(u: float, y: float, v: float) -> tuple[float, float, float]:
        return (u, y, v) if along_x else (v, y, u)

    radius = min(0.012, 0.2 * deep)
    yield rod(at(-half, s.h - radius, 0), at(half, s.h - radius, 0), radius, "metal", solid=False)
    drawn_aside = 2 * half > 0.8 and s.style.chance("two", 0.8)
    panels = ((-half, -0.42 * half), (0.42 * half, half)) if drawn_aside else ((-half, half),)
    fold = max(min(deep, 0.07), 0.55 * deep)
    for low, high in panels:
        count = max(3, round((high - low) / (1.7 * fold)))
        for i in range(count):
            u = low + (high - low) * (i + 0.5) / count
            wide = 1.16 * (high - low) / count
            thick = min(1.7 * fold, 1.5 * deep)
            shift = (1 if i % 2 else -1) * (deep - thick / 2)
            low_at, high_at = (
                np.minimum(at(u - wide / 2, 0, shift - thick / 2), at(u + wide / 2, top, shift + thick / 2)),
                np.maximum(at(u - wide / 2, 0, shift - thick / 2), at(u + wide / 2, top, shift + thick / 2)),
            )
            edge = half - wide / 2
            if abs(u) > edge:
                move = np.array(at(np.sign(u) * (edge - abs(u)), 0, 0))
                low_at, high_at = low_at + move, high_at + move
            yield span(low_at, high_at, "cloth", kind="cylinder", solid=False, segments=12)
        for i in range(count + 1):
            u = low + (high - low) * i / count
            u = float(np.clip(u, -half + 2.2 * radius, half - 2.2 * radius))
            turn = about("z", 90.0) if along_x else about("x", 90.0)
            yield Part(
                "torus", at(u, s.h - 1.6 * radius, 0), (3.2 * radius, 0.006, 3.2 * radius), turn, "metal", solid=False, ratio=0.3
            )
    reach = at(half, 0, deep)
    yield span((-reach[0], 0, -reach[2]), (reach[0], s.h, reach[2]), drawn=False)


def mirror(s: Subject) -> Iterator[Part]:
    """Yield a mirror in a frame."""
    st = s.style
    width = min(st.uniform("frame", 0.02, 0.07), 0.16 * min(s.w, s.h))
    back = -s.z
    yield span((-s.x + 0.002, 0.002, back), (s.x - 0.002, s.h - 0.002, back + 0.4 * s.d), "main")
    yield span(
        (-s.x + 0.8 * width, 0.8 * width, back),
        (s.x - 0.8 * width, s.h - 0.8 * width, back + 0.55 * s.d),
        "mirror",
        solid=False,
        bevel=0.004,
    )
    if st.chance("frameless", 0.25):
        yield span((-s.x, 0, back), (s.x, s.h, s.z), "mirror", solid=False, bevel=0.4 * s.d)
    else:
        yield from _frame(s, width, back, s.z, "main", min(0.012, 0.3 * s.d))


def painting(s: Subject) -> Iterator[Part]:
    """Frame, mount and picture; small thick ones are canvases without a frame."""
    st = s.style
    back = -s.z
    if st.chance("canvas", 0.3):
        yield span((-s.x, 0, back), (s.x, s.h, 0.96 * s.z), "main", bevel=0.003)
        yield span((-s.x * 0.998, 0.002, 0), (s.x * 0.998, s.h - 0.002, s.z), "picture", solid=False)
        return
    width = min(st.uniform("frame", 0.02, 0.06), 0.14 * min(s.w, s.h))
    mount = st.uniform("mount", 0.0, 0.13) * min(s.w, s.h)
    yield span((-s.x + 0.003, 0.003, back), (s.x - 0.003, s.h - 0.003, back + 0.5 * s.d), "second")
    yield span(
        (-s.x + width + mount, width + mount, back),
        (s.x - width - mount, s.h - width - mount, back + 0.58 * s.d),
        "picture",
        solid=False,
    )
    yield from _frame(s, width, back, s.z, "main", min(0.01, 0.3 * s.d))


def poster(s: Subject) -> Iterator[Part]:
    """Yield a poster."""
    yield span((-s.x, 0, -s.z), (s.x, s.h, 0.5 * s.z), "second")
    edge = 0.03 * min(s.w, s.h)
    yield span((-s.x + edge, edge, -s.z), (s.x - edge, s.h - edge, 0.7 * s.z), "picture", solid=False)
    for sx in (-1, 1):
        for y in (edge, s.h - edge):
            yield Part(
                "cylinder", (sx * (s.x - edge), y, 0.75 * s.z), (edge, 0.5 * s.z, edge), about("x", 90.0), "metal", solid=False
            )


FORMS = {
    "Window": window,
    "Blinds": blinds,
    "Curtains": curtains,
    "Mirror": mirror,
    "Painting": painting,
    "Poster": poster,
}
