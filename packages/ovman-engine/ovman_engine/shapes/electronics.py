"""Screens, telephones, clocks and other devices. Front at +z."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, arc, bar, lathe, prism, rod, span, tube
from ovman_engine.shapes.subject import Subject


def television(s: Subject) -> Iterator[Part]:
    """Yield a television."""
    st = s.style
    rim = st.uniform("rim", 0.012, 0.03)
    flat = s.d < 0.13
    panel = s.d if flat else st.uniform("panel", 0.045, 0.07)
    low = 0.0 if flat else st.uniform("neck", 0.06, 0.12) * s.h
    back = -panel / 2
    face = panel / 2
    yield span((-s.x, low, back), (s.x, s.h, face), "main", bevel=0.006)
    yield span((-s.x + rim, low + 1.4 * rim, face - 0.01), (s.x - rim, s.h - rim, face + 0.0012), "screen", solid=False)
    yield span(
        (-0.7 * s.x, low + 0.25 * s.h, back - 0.02 if not flat else back),
        (0.7 * s.x, s.h * 0.8, face - 0.02),
        "main",
        bevel=0.01,
        solid=False,
    )
    yield span((-0.03, low + 0.3 * rim, face - 0.002), (0.03, low + 0.9 * rim, face + 0.0016), "metal", solid=False)
    if flat:
        return
    if st.chance("two feet", 0.5):
        for sx in (-1, 1):
            x = sx * 0.62 * s.x
            yield span((x - 0.02, 0, -s.z), (x + 0.02, 0.014, s.z), "metal", bevel=0.004)
            yield span((x - 0.012, 0.008, -0.03), (x + 0.012, low + 0.02, 0.03), "metal", solid=False)
    else:
        yield span((-0.42 * s.x, 0, -s.z), (0.42 * s.x, 0.016, s.z), "metal", kind=st.choice("foot", ("box", "cylinder")))
        yield span((-0.1 * s.x, 0.01, back + 0.005), (0.1 * s.x, low + 0.03, back + 0.03), "metal")


def laptop(s: Subject) -> Iterator[Part]:
    """Open where its box is tall, closed where it is flat."""
    base = min(0.022, 0.5 * s.h)
    if s.h < 0.2 * s.d:
        yield span((-s.x, 0, -s.z), (s.x, 0.48 * s.h, s.z), "main", bevel=0.1 * s.h)
        yield span((-s.x, 0.52 * s.h, -s.z), (s.x, s.h, s.z), "second", bevel=0.1 * s.h)
        yield Part("cylinder", (0, s.h, 0), (0.04, 0.001, 0.04), slot="metal", solid=False)
        return
    lid = 0.009
    lean = min(0.32 * s.h, 0.3 * s.d)
    hinge = -s.z + lean
    yield span((-s.x, 0, hinge), (s.x, base, s.z), "main", bevel=0.004)
    keys_z0, keys_z1 = hinge + 0.1 * (s.z - hinge), hinge + 0.62 * (s.z - hinge)
    yield span((-0.9 * s.x, base - 0.004, keys_z0), (0.9 * s.x, base + 0.0008, keys_z1), "dark", solid=False)
    rows, columns = 5, 13
    for i in range(rows):
        for j in range(columns):
            x = -0.87 * s.x + 1.74 * s.x * j / columns
            z = keys_z0 + (keys_z1 - keys_z0) * (i + 0.12) / rows
            yield span(
                (x, base, z),
                (x + 1.5 * s.x / columns, base + 0.0022, z + 0.76 * (keys_z1 - keys_z0) / rows),
                "second",
                solid=False,
            )
    yield span((-0.26 * s.x, base - 0.003, keys_z1 + 0.02), (0.26 * s.x, base + 0.0008, s.z - 0.012), "second", solid=False)
    foot, head = (0, base * 0.6, hinge), (0, s.h, -s.z + lid / 2)
    yield bar(foot, head, s.w, lid, "main", bevel=0.003)
    yield rod((-0.7 * s.x, base * 0.7, hinge), (0.7 * s.x, base * 0.7, hinge), 0.007, "dark", solid=False)
    rise = (s.h - base * 0.6, -s.z + lid / 2 - hinge)
    offset = 0.0018
    low = (0, foot[1] + 0.08 * rise[0] + offset, foot[2] + 0.08 * rise[1] + lid / 2)
    high = (0, foot[1] + 0.95 * rise[0] + offset, foot[2] + 0.95 * rise[1] + lid / 2)
    yield bar(low, high, 0.93 * s.w, 0.0022, "screen", solid=False)


def desktop(s: Subject) -> Iterator[Part]:
    """Yield a tower, a monitor on its foot, a keyboard and a mouse."""
    tower = 0.24 * s.w
    yield span((-s.x, 0, -s.z), (-s.x + tower, 0.82 * s.h, s.z * 0.7), "main", bevel=0.006)
    yield span((-s.x + 0.02, 0.55 * s.h, s.z * 0.66), (-s.x + tower - 0.02, 0.78 * s.h, s.z * 0.72), "dark", solid=False)
    yield Part(
        "cylinder", (-s.x + tower / 2, 0.46 * s.h, 0.71 * s.z), (0.02, 0.012, 0.02), about("x", 90.0), "accent", solid=False
    )
    left = -s.x + tower + 0.06 * s.w
    middle = (left + s.x) / 2
    yield span((left, 0.2 * s.h, -0.4 * s.z), (s.x, s.h, -0.4 * s.z + 0.04), "dark", bevel=0.006)
    yield span(
        (left + 0.014, 0.2 * s.h + 0.02, -0.4 * s.z + 0.03),
        (s.x - 0.014, s.h - 0.014, -0.4 * s.z + 0.0415),
        "screen",
        solid=False,
    )
    yield span((middle - 0.03, 0, -0.55 * s.z), (middle + 0.03, 0.5 * s.h, -0.4 * s.z), "metal")
    yield span((middle - 0.12, 0, -0.95 * s.z), (middle + 0.12, 0.014, 0.1 * s.z), "metal", bevel=0.004)
    yield span((left, 0, 0.35 * s.z), (s.x - 0.1, 0.02, s.z), "second", bevel=0.004)
    for i in range(4):
        for j in range(14):
            x = left + 0.01 + (s.x - 0.12 - left) * j / 14
            z = 0.35 * s.z + 0.008 + (0.62 * s.z - 0.01) * i / 4
            yield span((x, 0.018, z), (x + 0.024, 0.026, z + 0.13 * s.z), "pale", bevel=0.002, solid=False)
    yield span((s.x - 0.07, 0, 0.4 * s.z), (s.x, 0.034, 0.95 * s.z), "second", kind="ellipsoid")


def cell_phone(s: Subject) -> Iterator[Part]:
    """Yield a telephone."""
    rim = 0.05 * s.w
    yield span((-s.x, 0, -s.z), (s.x, 0.88 * s.h, s.z), "main", bevel=min(0.3 * s.h, 0.004))
    yield span((-s.x + rim, 0.8 * s.h, -s.z + 2 * rim), (s.x - rim, 0.95 * s.h, s.z - 2 * rim), "screen", solid=False)
    yield Part("cylinder", (0, 0.92 * s.h, s.z - rim), (0.12 * s.w, 0.16 * s.h, 0.1 * s.w), slot="dark", solid=False)


def remote_control(s: Subject) -> Iterator[Part]:
    """Yield a remote control."""
    yield span((-s.x, 0, -s.z), (s.x, 0.75 * s.h, s.z), "main", bevel=0.25 * s.h)
    yield Part("cylinder", (0, 0.85 * s.h, 0.25 * s.d), (0.5 * s.w, 0.3 * s.h, 0.5 * s.w), slot="second", solid=False)
    yield Part("cylinder", (-0.26 * s.w, 0.85 * s.h, 0.43 * s.d), (0.2 * s.w, 0.3 * s.h, 0.2 * s.w), slot="accent", solid=False)
    for i in range(5):
        for j in range(3):
            x, z = (j - 1) * 0.28 * s.w, 0.06 * s.d - i * 0.1 * s.d
            yield span(
                (x - 0.09 * s.w, 0.7 * s.h, z - 0.03 * s.d),
                (x + 0.09 * s.w, s.h, z + 0.03 * s.d),
                "pale",
                bevel=0.001,
                solid=False,
            )


SEGMENTS = ("abcdef", "bc", "abdeg", "abcdg", "bcfg", "acdfg", "acdefg", "abc", "abcdefg", "abcdfg")
"""Strokes of each digit: a top, b upper right, c lower right, d bottom, e lower left, f upper left, g middle."""


def _digit(s: Subject, x: float, wide: float, low: float, high: float, strokes: str) -> Iterator[Part]:
    """Yield a digit of seven strokes centred at `x` on the face of a clock."""
    thick = 0.22 * wide
    middle = (low + high) / 2
    for name, y in (("a", high - thick), ("g", middle - thick / 2), ("d", low)):
        if name in strokes:
            yield span((x - wide / 2, y, 0.9 * s.z), (x + wide / 2, y + thick, s.z), "glow", solid=False)
    for names, sign in (("fe", 1), ("bc", -1)):
        left = x + sign * (wide / 2 - thick / 2) - thick / 2
        for name, y0, y1 in ((names[0], middle, high), (names[1], low, middle)):
            if name in strokes:
                yield span((left, y0, 0.9 * s.z), (left + thick, y1, s.z), "glow", solid=False)


def alarm_clock(s: Subject) -> Iterator[Part]:
    """Yield an alarm clock with digits."""
    st = s.style
    if s.w > 1.25 * s.h or st.chance("digital", 0.35):
        yield prism([(-s.x, 0), (s.x, 0), (0.92 * s.x, s.h * 0.94), (-0.92 * s.x, s.h * 0.94)], -s.z, s.z * 0.94, "main")
        yield span((-0.78 * s.x, 0.16 * s.h, 0.9 * s.z), (0.78 * s.x, 0.8 * s.h, 0.97 * s.z), "dark", solid=False)
        hour, minute = st.whole("hour", 10, 23), st.whole("minute", 10, 59)
        # seen from the front, +x is on the left
        for x, digit in zip((0.52, 0.2, -0.2, -0.52), f"{hour}{minute}", strict=True):
            yield from _digit(s, x * s.x, 0.24 * s.x, 0.26 * s.h, 0.7 * s.h, SEGMENTS[int(digit)])
        for y in (0.38, 0.56):
            yield span((-0.03 * s.x, y * s.h, 0.9 * s.z), (0.03 * s.x, (y + 0.04) * s.h, s.z), "glow", solid=False)
        yield span((-0.3 * s.x, 0.9 * s.h, -0.4 * s.z), (0.3 * s.x, s.h, 0.4 * s.z), "accent", bevel=0.002, solid=False)
        return
    radius = min(s.x, 0.38 * s.h)
    middle = 0.1 * s.h + radius
    turn = about("x", 90.0)
    yield Part("cylinder", (0, middle, 0), (2 * s.x, s.d * 0.9, 2 * radius), turn, "main")
    yield Part("cylinder", (0, middle, 0.46 * s.d), (1.7 * s.x, 0.06 * s.d, 1.7 * radius), turn, "pale", solid=False)
    yield Part("torus", (0, middle, 0.45 * s.d), (2 * s.x, 0.1 * s.d, 2 * radius), turn, "metal", solid=False, ratio=0.16)
    for degrees, reach in ((st.uniform("hour", 0, 360), 0.45), (st.uniform("minute", 0, 360), 0.7)):
        tip = about("z", degrees) @ [0, reach * radius, 0]
        yield bar((0, middle, 0.485 * s.d), tip + [0, middle, 0.485 * s.d], 0.05 * s.w, 0.02 * s.d, "dark", solid=False)
    for sx in (-1, 1):
        yield Part(
            "ellipsoid",
            (sx * 0.5 * s.x, middle + 0.95 * radius, 0),
            (0.62 * s.x, 0.34 * radius, 0.7 * s.d),
            about("z", -sx * 24.0),
            "metal",
            solid=False,
        )
        yield rod((sx * 0.45 * s.x, 0, 0), (sx * 0.3 * s.x, middle - 0.8 * radius, 0), 0.04 * s.w, "metal")
    path = arc((0, middle + radius, 0), 0.45 * s.x, 0, 180, "xy", 7)
    path[:, 1] = middle + radius + (path[:, 1] - middle - radius) * max(0.2, (s.h - middle - radius - 0.01) / (0.45 * s.x))
    yield tube(path, 0.03 * s.w, "metal", solid=False)


def watch(s: Subject) -> Iterator[Part]:
    """Yield a wrist watch that stands on its closed strap, its dial up."""
    case = min(0.85 * s.d, 0.55 * s.w)
    yield Part("torus", (0, 0.46 * s.h, 0), (s.w, 0.5 * s.d, 0.92 * s.h), about("x", 90.0), "cloth", solid=False, ratio=0.12)
    yield span((-s.x, 0, -0.25 * s.d), (s.x, 0.9 * s.h, 0.25 * s.d), drawn=False, kind="ellipsoid")
    yield Part("cylinder", (0, 0.86 * s.h, 0), (case, 0.26 * s.h, s.d), slot="metal")
    yield Part("cylinder", (0, 0.985 * s.h, 0), (0.8 * case, 0.02 * s.h, 0.8 * s.d), slot="pale", solid=False)
    yield bar((0, 0.99 * s.h, 0), (0.28 * case, 0.99 * s.h, 0), 0.02 * s.h, 0.06 * case, "dark", solid=False)
    yield bar((0, 0.99 * s.h, 0), (0, 0.99 * s.h, 0.34 * case), 0.02 * s.h, 0.05 * case, "dark", solid=False)


def compact_disc(s: Subject) -> Iterator[Part]:
    """Yield a compact disc."""
    ring = [(0.16, 0), (1, 0), (1, 0.9), (0.16, 0.9), (0.16, 0)]
    yield Part("cylinder", (0, s.h / 2, 0), (s.w, s.h, s.d), drawn=False)
    yield lathe([(r * s.x, y * s.h) for r, y in ring], slot="metal", stretch=(1.0, s.z / s.x), solid=False, segments=32)
    label = [(0.2, 0.2), (0.62, 0.2), (0.62, 1.0), (0.2, 1.0), (0.2, 0.2)]
    yield lathe([(r * s.x, y * s.h) for r, y in label], slot="picture", stretch=(1.0, s.z / s.x), solid=False, segments=32)


def vacuum_cleaner(s: Subject) -> Iterator[Part]:
    """Yield an upright cleaner: head on the floor, canister, leaning handle."""
    yield span((-s.x, 0, 0.1 * s.d), (s.x, 0.09 * s.h, s.z), "main", bevel=0.02)
    yield span((-0.8 * s.x, 0.0, s.z - 0.02), (0.8 * s.x, 0.03, s.z), "dark", solid=False)
    yield rod((0, 0.08 * s.h, 0.15 * s.d), (0, 0.55 * s.h, -0.28 * s.d), 0.36 * s.x, "second")
    yield rod((0, 0.5 * s.h, -0.24 * s.d), (0, 0.58 * s.h, -0.31 * s.d), 0.4 * s.x, "main", solid=False)
    yield rod((0, 0.55 * s.h, -0.28 * s.d), (0, 0.95 * s.h, -0.44 * s.d), 0.014, "metal")
    yield tube(
        [(0, 0.86 * s.h, -0.4 * s.d), (0, 0.98 * s.h, -0.36 * s.d), (0, 0.985 * s.h, -0.46 * s.d), (0, 0.9 * s.h, -0.47 * s.d)],
        0.015,
        "dark",
        solid=False,
    )
    for sx in (-1, 1):
        yield rod((sx * 0.7 * s.x, 0.06 * s.h, -0.05 * s.d), (sx * s.x, 0.06 * s.h, -0.05 * s.d), 0.06 * s.h, "dark", solid=False)


FORMS = {
    "Television": television,
    "Laptop": laptop,
    "Desktop": desktop,
    "CellPhone": cell_phone,
    "RemoteControl": remote_control,
    "AlarmClock": alarm_clock,
    "Watch": watch,
    "CD": compact_disc,
    "VacuumCleaner": vacuum_cleaner,
}
