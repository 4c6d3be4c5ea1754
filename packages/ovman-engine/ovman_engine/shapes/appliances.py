"""Kitchen appliances and the parts of a stove. Front at +z."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.fronts import handle
from ovman_engine.shapes.part import Part, about, arc, bar, column, lathe, rod, span, tube
from ovman_engine.shapes.subject import Subject

FRIDGE_HANDLE_M = 0.0225
"""How far a fridge's handle stands out of its door: in FloorPlan28, a ray of AI2-THOR meets the door so far behind the box."""


def fridge(s: Subject) -> Iterator[Part]:
    """Yield a fridge with one or two doors."""
    st = s.style
    face = s.z - FRIDGE_HANDLE_M
    door = 0.06
    yield span((-s.x + 0.004, 0.03, -s.z), (s.x - 0.004, s.h - 0.01, face - door - 0.006), "second", bevel=0.008)
    yield span((-s.x + 0.02, 0, -s.z + 0.03), (s.x - 0.02, 0.05, face - door), "dark", solid=False)
    yield span((-s.x, 0.05, face - door), (s.x, s.h, face), drawn=False)
    form = st.choice("doors", ("freezer above", "freezer below", "french", "side by side"))
    gap = 0.006

    def leaf(x0: float, x1: float, y0: float, y1: float, opens: float, upright: bool = True) -> Iterator[Part]:
        yield span((x0, y0, face - door), (x1, y1, face), "main", bevel=0.012, solid=False)
        radius = 0.011
        if upright:
            x = opens
            low, high = (x, y0 + 0.12 * (y1 - y0), s.z - radius), (x, y1 - 0.12 * (y1 - y0), s.z - radius)
        else:
            low, high = (x0 + 0.15 * (x1 - x0), opens, s.z - radius), (x1 - 0.15 * (x1 - x0), opens, s.z - radius)
        yield rod(low, high, radius, "metal", solid=False)
        for end in (low, high):
            yield rod((end[0], end[1], face), end, radius * 0.8, "metal", solid=False)

    side = 1 if st.chance("opens right", 0.5) else -1
    if form == "freezer above":
        cut = s.h * st.uniform("cut", 0.64, 0.74)
        yield from leaf(-s.x, s.x, cut + gap, s.h, side * (s.x - 0.05))
        yield from leaf(-s.x, s.x, 0.05, cut, side * (s.x - 0.05))
    elif form == "freezer below":
        cut = s.h * st.uniform("cut", 0.32, 0.4)
        yield from leaf(-s.x, s.x, cut + gap, s.h, side * (s.x - 0.05))
        yield from leaf(-s.x, s.x, 0.05, cut, cut - 0.07, upright=False)
    else:
        cut = s.h * 0.36 if form == "french" else 0.05
        split = 0.0 if form == "french" else -0.14 * s.w
        yield from leaf(-s.x, split - gap / 2, cut + gap, s.h, split - 0.04)
        yield from leaf(split + gap / 2, s.x, cut + gap, s.h, split + 0.04)
        if form == "french":
            yield from leaf(-s.x, s.x, 0.05, cut, cut - 0.07, upright=False)
        if st.chance("dispenser", 0.5):
            x = (-s.x + split) / 2
            y = s.h * 0.6
            yield span((x - 0.08, y - 0.15, face - 0.01), (x + 0.08, y + 0.16, face + 0.004), "dark", bevel=0.004, solid=False)
            yield span((x - 0.06, y + 0.07, face), (x + 0.06, y + 0.13, face + 0.008), "screen", solid=False)
    if st.chance("magnets", 0.4):
        for i in range(3):
            x, y = st.uniform(f"note x {i}", -0.6, 0.3) * s.x, s.h * st.uniform(f"note y {i}", 0.75, 0.9)
            yield span((x, y, face), (x + 0.07, y + 0.09, face + 0.002), "picture", solid=False)


def microwave(s: Subject) -> Iterator[Part]:
    """Yield a microwave oven."""
    st = s.style
    reach = 0.03
    face = s.z - reach
    panel = st.uniform("panel", 0.24, 0.3) * s.w
    yield span((-s.x, 0.012, -s.z), (s.x, s.h, face), "main", bevel=0.008)
    for sx in (-0.8, 0.8):
        for z in (-0.7 * s.z, 0.5 * s.z):
            yield column(sx * s.x, z, 0, 0.014, 0.015, "dark", solid=False)
    split = s.x - panel
    yield span((-s.x + 0.012, 0.03, face - 0.006), (split - 0.004, s.h - 0.018, face + 0.01), "second", bevel=0.004, solid=False)
    yield span((-s.x + 0.07, 0.085, face), (split - 0.075, s.h - 0.075, face + 0.012), "dark", bevel=0.003, solid=False)
    yield span((split + 0.004, 0.03, face - 0.006), (s.x - 0.012, s.h - 0.018, face + 0.006), "dark", bevel=0.003, solid=False)
    yield span((split + 0.02, s.h - 0.085, face), (s.x - 0.028, s.h - 0.04, face + 0.008), "glow", solid=False)
    for i in range(4):
        for j in range(3):
            x = split + 0.022 + (panel - 0.052) * j / 3
            y = 0.05 + (s.h - 0.16) * i / 4
            yield span((x, y, face), (x + (panel - 0.06) / 3.6, y + 0.6 * (s.h - 0.16) / 4, face + 0.009), "pale", solid=False)
    yield from handle(split - 0.035, (s.h + 0.012) / 2, face + 0.01, st, True, 0.68 * s.h, s.z - face - 0.01)


def toaster(s: Subject) -> Iterator[Part]:
    """Its long side runs along z; slots run the same way, the lever is at the front."""
    st = s.style
    foot = 0.012
    reach = min(0.03, 0.1 * s.d)
    yield span(
        (-s.x, foot, -s.z),
        (s.x, s.h, s.z - reach),
        "main",
        kind=st.choice("form", ("box", "cushion")),
        ratio=0.28,
        bevel=st.uniform("bevel", 0.012, 0.04),
    )
    yield span(
        (-s.x * 0.92, 0, -s.z * 0.92), (s.x * 0.92, 0.05 * s.h + foot, s.z * 0.92 - reach), "dark", bevel=0.004, solid=False
    )
    count = 2 if s.w < 0.27 else 4
    for i in range(count):
        x = -0.72 * s.x + 1.44 * s.x * (i + 0.5) / count
        yield span((x - 0.014, 0.9 * s.h, -0.72 * s.z), (x + 0.014, s.h + 0.0015, 0.62 * s.z), "dark", solid=False, bevel=0.003)
    if st.chance("bread", 0.4):
        yield span(
            (-0.36 * s.x - 0.01, 0.8 * s.h, -0.5 * s.z), (-0.36 * s.x + 0.01, s.h, 0.4 * s.z), "accent", bevel=0.008, solid=False
        )
    face = s.z - reach
    yield span((-0.012, 0.3 * s.h, face - 0.01), (0.012, 0.85 * s.h, face + 0.004), "dark", solid=False)
    yield span((-0.035, 0.66 * s.h, face), (0.035, 0.75 * s.h, s.z), "second", bevel=0.004, solid=False)
    yield Part("cylinder", (0.5 * s.x, 0.3 * s.h, face + 0.007), (0.032, 0.02, 0.032), about("x", 90.0), "metal", solid=False)


def coffee_machine(s: Subject) -> Iterator[Part]:
    """Yield a coffee machine."""
    st = s.style
    foot = 0.05 * s.h
    front = s.z - 0.03
    tower = st.uniform("tower", 0.36, 0.46) * s.d
    yield span((-s.x, 0, -s.z), (s.x, foot, s.z), "main", bevel=0.01)
    yield span((-s.x, foot, -s.z), (s.x, 0.7 * s.h, -s.z + tower), "main", bevel=0.01)
    yield span((-s.x, 0.68 * s.h, -s.z), (s.x, 0.93 * s.h, front), "main", bevel=0.02)
    yield span((-0.8 * s.x, 0.9 * s.h, -0.85 * s.z), (0.8 * s.x, s.h, 0.1 * s.z), "second", bevel=0.012)
    yield span((-0.8 * s.x, 0.74 * s.h, front - 0.01), (0.8 * s.x, 0.88 * s.h, front + 0.006), "dark", bevel=0.004, solid=False)
    yield span((-0.2 * s.x, 0.77 * s.h, front), (0.2 * s.x, 0.85 * s.h, front + 0.009), "glow", solid=False)
    for sx in (-0.55, 0.55):
        yield Part(
            "cylinder",
            (sx * s.x, 0.81 * s.h, front + 0.008),
            (0.05 * s.w + 0.012, 0.018, 0.05 * s.w + 0.012),
            about("x", 90.0),
            "metal",
            solid=False,
        )
    z = (-s.z + tower + front) / 2
    radius = min(0.34 * s.w, 0.4 * (front + s.z - tower))
    if st.chance("carafe", 0.6):
        y = foot + 0.01
        high = 0.48 * s.h
        profile = [
            (0, y),
            (0.85 * radius, y),
            (radius, y + 0.12 * high),
            (0.95 * radius, y + 0.55 * high),
            (0.62 * radius, y + 0.9 * high),
            (0.66 * radius, y + high),
            (0, y + high),
        ]
        yield lathe(profile, 0, z, "glass")
        yield lathe(
            [
                (0, y + 0.01),
                (0.8 * radius, y + 0.012),
                (0.97 * radius, y + 0.14 * high),
                (0.9 * radius, y + 0.4 * high),
                (0, y + 0.4 * high),
            ],
            0,
            z,
            "dark",
            solid=False,
        )
        yield tube(
            [
                (0, y + 0.85 * high, z + 0.6 * radius),
                (0, y + 0.8 * high, z + 1.25 * radius),
                (0, y + 0.25 * high, z + 1.25 * radius),
                (0, y + 0.2 * high, z + 0.9 * radius),
            ],
            0.009,
            "dark",
            solid=False,
        )
        yield column(0, z, 0.6 * s.h, 0.7 * s.h, 0.7 * radius, "dark", solid=False, kind="frustum", ratio=1.3)
    else:
        yield column(0, z, 0.58 * s.h, 0.69 * s.h, 0.6 * radius, "metal", solid=False)
        yield rod((0, 0.61 * s.h, z), (0, 0.6 * s.h, s.z), 0.012, "dark", solid=False)
        yield span((-0.7 * s.x, foot, -s.z + tower), (0.7 * s.x, foot + 0.015, s.z * 0.92), "metal", bevel=0.003, solid=False)
        yield lathe(
            [
                (0, foot + 0.016),
                (0.03, foot + 0.016),
                (0.04, foot + 0.09),
                (0.036, foot + 0.09),
                (0.026, foot + 0.02),
                (0, foot + 0.02),
            ],
            0,
            z,
            "pale",
            solid=False,
        )


def kettle(s: Subject) -> Iterator[Part]:
    """Spout at -z, handle at +z or over the top, by asset."""
    st = s.style
    radius = 0.78 * min(s.x, s.z)
    z = 0.18 * s.z
    body = 0.62 * s.h
    yield lathe(
        [(0, 0), (0.92 * radius, 0), (radius, 0.12 * body), (0.9 * radius, 0.6 * body), (0.45 * radius, body), (0, body)],
        0,
        z,
        "main",
    )
    yield lathe(
        [(0, body - 0.004), (0.42 * radius, body - 0.004), (0.3 * radius, body + 0.05 * s.h), (0, body + 0.07 * s.h)],
        0,
        z,
        "second",
        solid=False,
    )
    yield Part("ellipsoid", (0, body + 0.1 * s.h, z), (0.2 * radius, 0.09 * s.h, 0.2 * radius), slot="dark", solid=False)
    yield rod(
        (0, 0.32 * body, z - 0.7 * radius),
        (0, 0.95 * body, -s.z + 0.012),
        0.17 * radius,
        "main",
        kind="frustum",
        ratio=0.55,
        solid=False,
    )
    top = arc((0, 0.55 * body, z), 1.0, 15, 165, "zy", 11)
    top[:, 2] = z + (top[:, 2] - z) * 0.78 * radius
    top[:, 1] = 0.55 * body + (top[:, 1] - 0.55 * body) * (s.h - 0.55 * body - 0.008)
    yield tube(top, 0.008 + 0.02 * st.fraction("handle") * s.h, "dark", solid=False)
    yield span((-s.x, 0.28 * body, z - 0.01), (s.x, 0.3 * body, z + 0.01), "metal", solid=False)


def burner(s: Subject) -> Iterator[Part]:
    """Yield a ring of gas flames under a grate, or a coil, by asset."""
    y = s.h
    if s.style.chance("coil", 0.4) or s.h < 0.012:
        yield span((-s.x, 0, -s.z), (s.x, 0.35 * y, s.z), "second", kind="cylinder", segments=32)
        for i in range(4):
            share = 0.9 - 0.22 * i
            yield span(
                (-share * s.x, 0.3 * y, -share * s.z),
                (share * s.x, y, share * s.z),
                "main",
                kind="torus",
                ratio=0.1 / share,
                solid=False,
                segments=28,
            )
        return
    yield span((-0.8 * s.x, 0, -0.8 * s.z), (0.8 * s.x, 0.3 * y, 0.8 * s.z), "second", kind="cylinder", segments=28)
    yield span(
        (-0.36 * s.x, 0.2 * y, -0.36 * s.z), (0.36 * s.x, 0.75 * y, 0.36 * s.z), "main", kind="frustum", ratio=0.8, solid=False
    )
    yield span(
        (-s.x, 0.45 * y, -s.z),
        (s.x, y, s.z),
        "main",
        kind="torus",
        ratio=0.09,
        solid=False,
        segments=4 if s.style.chance("square", 0.5) else 28,
    )
    for i in range(4):
        tip = about("y", 45.0 + 90.0 * i) @ [0, 0, 1.0]
        yield bar(
            (0.2 * s.x * tip[0], 0.85 * y, 0.2 * s.z * tip[2]),
            (0.97 * s.x * tip[0], 0.85 * y, 0.97 * s.z * tip[2]),
            0.3 * y,
            0.009,
            "main",
            solid=False,
        )
    yield span((-s.x, 0, -s.z), (s.x, y, s.z), drawn=False)


def stove_knob(s: Subject) -> Iterator[Part]:
    """Yield a knob on a plate; it stands out along +z if upright, along +y if it lies on the hob."""
    if s.h <= 0.6 * min(s.w, s.d):
        yield span((-s.x, 0, -s.z), (s.x, 0.25 * s.h, s.z), "metal", kind="cylinder")
        yield span((-0.8 * s.x, 0, -0.8 * s.z), (0.8 * s.x, 0.9 * s.h, 0.8 * s.z), "main", kind="frustum", ratio=0.85)
        yield span((-0.12 * s.x, 0.5 * s.h, -0.78 * s.z), (0.12 * s.x, s.h, 0.78 * s.z), "accent", solid=False)
        return
    turn = about("x", 90.0)
    yield Part("cylinder", (0, s.h / 2, -0.4 * s.d), (s.w, 0.2 * s.d, s.h), turn, "metal")
    yield Part("frustum", (0, s.h / 2, 0.05 * s.d), (0.8 * s.w, 0.8 * s.d, 0.8 * s.h), turn, "main", ratio=0.85)
    yield span((-0.08 * s.w, 0.16 * s.h, 0.2 * s.d), (0.08 * s.w, 0.84 * s.h, s.z), "accent", solid=False)


FORMS = {
    "Fridge": fridge,
    "Microwave": microwave,
    "Toaster": toaster,
    "CoffeeMachine": coffee_machine,
    "Kettle": kettle,
    "StoveBurner": burner,
    "StoveKnob": stove_knob,
}
