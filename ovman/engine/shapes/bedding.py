"""Beds and what is soft: pillows, cloths, towels, a bear. The bed's head is at -z here; `facing` turns it."""

from __future__ import annotations

from collections.abc import Iterator

from ovman.engine.shapes.part import Part, about, span
from ovman.engine.shapes.seating import legs
from ovman.engine.shapes.subject import Subject


def bed(s: Subject) -> Iterator[Part]:
    st = s.style
    lying = min(0.55, 0.62 * s.h)
    frame = st.uniform("frame", 0.2, 0.3) * lying / 0.55
    foot = st.uniform("foot", 0.05, 0.12)
    head = st.uniform("head", 0.04, 0.09)
    board = lying + st.uniform("footboard", -0.05, 0.14) if st.chance("has footboard", 0.4) else frame
    yield span((-s.x, foot, -s.z + head), (s.x, frame, s.z), "main", bevel=0.012)
    yield from legs(s, foot + 0.02, 0.02, 0.07, 0.0, "trim", solid=False)
    form = st.choice("headboard", ("panel", "slats", "soft", "buttoned"))
    yield span(
        (-s.x, 0, -s.z),
        (s.x, s.h, -s.z + head),
        drawn=form != "slats",
        slot="cloth_second" if form in ("soft", "buttoned") else "main",
        bevel=0.015,
    )
    if form == "slats":
        for sx in (-1, 1):
            low, high = sorted((sx * s.x, sx * (s.x - 0.06)))
            yield span((low, 0, -s.z), (high, s.h, -s.z + head), "main", bevel=0.006, solid=False)
        for y in (lying, s.h - 0.07):
            yield span((-s.x, y, -s.z + 0.01), (s.x, y + 0.065, -s.z + head - 0.01), "main", bevel=0.006, solid=False)
        count = max(5, round(s.w / 0.14))
        for i in range(1, count):
            x = -s.x + s.w * i / count
            yield span((x - 0.014, lying, -s.z + 0.02), (x + 0.014, s.h - 0.02, -s.z + head - 0.02), "main", solid=False)
    elif form == "buttoned":
        count = max(3, round(s.w / 0.3))
        for i in range(count):
            for row in range(2):
                high = (s.h - lying) / 2
                x0 = -s.x + s.w * i / count
                yield span(
                    (x0 + 0.003, lying + row * high, -s.z + head - 0.02),
                    (x0 + s.w / count - 0.003, lying + (row + 1) * high, -s.z + head + 0.03),
                    "cloth_second",
                    kind="cushion",
                    ratio=0.3,
                    solid=False,
                )
    elif form == "panel":
        yield span(
            (-s.x * 0.9, lying, -s.z + head - 0.01),
            (s.x * 0.9, s.h - 0.06, -s.z + head + 0.008),
            "second",
            bevel=0.006,
            solid=False,
        )
    if board > frame:
        yield span((-s.x, 0, s.z - 0.05), (s.x, board, s.z), "main", bevel=0.012)
    end = s.z - 0.06
    yield span((-s.x + 0.03, frame, -s.z + head), (s.x - 0.03, lying - 0.04, end), "pale", kind="cushion", ratio=0.12)
    count = 1 if s.w < 1.25 else 2
    wide = (s.w - 0.16) / count
    depth = min(0.42, 0.2 * s.d)
    for i in range(count):
        x = -s.x + 0.08 + wide * (i + 0.5)
        yield Part(
            "cushion",
            (x, lying + 0.05, -s.z + head + depth / 2 + 0.04),
            (wide * 0.92, 0.15, depth),
            about("x", -16.0),
            "cloth",
            solid=False,
            ratio=0.55,
        )
    turn = -s.z + head + depth + st.uniform("turn", 0.06, 0.3)
    yield span(
        (-s.x + 0.005, frame - st.uniform("hang", 0.0, 0.12), turn),
        (s.x - 0.005, lying + 0.02, end + 0.01),
        "cloth_second",
        kind="cushion",
        ratio=0.1,
        solid=False,
    )
    yield span(
        (-s.x + 0.005, lying - 0.02, turn - 0.02),
        (s.x - 0.005, lying + 0.045, turn + 0.24),
        "accent",
        kind="cushion",
        ratio=0.25,
        solid=False,
    )
    if st.chance("throw", 0.5):
        far = turn + 0.62 * (end - turn)
        yield span((-s.x, frame - 0.04, far), (s.x, lying + 0.035, far + 0.4), "accent", kind="cushion", ratio=0.1, solid=False)


def pillow(s: Subject) -> Iterator[Part]:
    yield span(
        (-s.x, 0, -s.z),
        (s.x, s.h, s.z),
        "cloth",
        kind="cushion",
        ratio=s.style.uniform("square", 0.28, 0.45),
        crown=s.style.uniform("puff", 0.85, 1.25),
        segments=32,
    )
    if s.style.chance("piping", 0.4):
        yield span(
            (-s.x * 0.97, 0.47 * s.h, -s.z * 0.97),
            (s.x * 0.97, 0.53 * s.h, s.z * 0.97),
            "accent",
            kind="cushion",
            ratio=0.4,
            solid=False,
            segments=28,
        )


def cloth(s: Subject) -> Iterator[Part]:
    """A folded cloth: layers of slightly different reach."""
    layers = 3
    step = s.h / layers
    for i in range(layers):
        inset = 0.02 * s.w * s.style.fraction(f"layer {i}") if i else 0.0
        yield span(
            (-s.x + inset, i * step, -s.z + inset),
            (s.x - 0.5 * inset, (i + 1) * step, s.z - 0.5 * inset),
            "cloth",
            bevel=0.3 * step,
        )
    yield span(
        (-s.x * 0.72, 0.1 * s.h, -s.z * 0.985), (-s.x * 0.58, s.h + 0.0004, s.z * 0.985), "accent", solid=False, bevel=0.2 * step
    )


def towel(s: Subject) -> Iterator[Part]:
    """A towel over a rail: a short flap behind a long one in front, hem stripes across."""
    fold = min(0.5 * s.d, 0.012)
    front = s.z - fold
    yield span((-s.x, s.h - 1.6 * fold, -s.z), (s.x, s.h, s.z), "cloth", kind="cushion", ratio=0.25, solid=False)
    yield span((-s.x, 0, front), (s.x, s.h - fold, s.z), "cloth", bevel=0.003)
    yield span(
        (-s.x * 0.99, s.style.uniform("back", 0.05, 0.3) * s.h, -s.z), (s.x * 0.99, s.h - fold, -s.z + fold), "cloth", bevel=0.003
    )
    for i in range(s.style.whole("stripes", 1, 3)):
        y = 0.09 * s.h + 0.05 * s.h * i
        yield span((-s.x, y, front - 0.0004), (s.x, y + 0.022 * s.h, s.z + 0.0004), "accent", solid=False)
    count = 5
    for i in range(count):
        x = -s.x + s.w * (i + 0.5) / count
        yield span(
            (x - 0.4 * s.w / count, 0.01, front + 0.25 * fold),
            (x + 0.4 * s.w / count, s.h - 1.5 * fold, s.z + 0.0003),
            "cloth",
            kind="cushion",
            ratio=0.4,
            solid=False,
        )


def teddy(s: Subject) -> Iterator[Part]:
    """A sitting bear, facing +z."""
    head = 0.46 * s.h
    yield span((-0.3 * s.w, 0.0, -s.z), (0.3 * s.w, 0.62 * s.h, 0.2 * s.d), "cloth", kind="ellipsoid")
    yield span((-0.29 * s.w, s.h - head, -0.42 * s.d), (0.29 * s.w, s.h - 0.04 * s.h, 0.32 * s.d), "cloth", kind="ellipsoid")
    yield Part(
        "ellipsoid", (0, s.h - 0.6 * head, 0.3 * s.d), (0.24 * s.w, 0.16 * s.h, 0.2 * s.d), slot="cloth_second", solid=False
    )
    yield Part("ellipsoid", (0, s.h - 0.53 * head, 0.4 * s.d), (0.08 * s.w, 0.05 * s.h, 0.05 * s.d), slot="dark", solid=False)
    yield Part("ellipsoid", (0, 0.28 * s.h, 0.14 * s.d), (0.36 * s.w, 0.4 * s.h, 0.16 * s.d), slot="cloth_second", solid=False)
    for sx in (-1, 1):
        yield Part(
            "ellipsoid",
            (sx * 0.22 * s.w, s.h - 0.08 * s.h, -0.04 * s.d),
            (0.18 * s.w, 0.16 * s.h, 0.1 * s.d),
            slot="cloth",
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.1 * s.w, s.h - 0.4 * head, 0.3 * s.d),
            (0.045 * s.w, 0.045 * s.h, 0.03 * s.d),
            slot="dark",
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.37 * s.w, 0.4 * s.h, 0.1 * s.d),
            (0.2 * s.w, 0.42 * s.h, 0.26 * s.d),
            about("z", sx * 32.0),
            "cloth",
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.3 * s.w, 0.11 * s.h, 0.24 * s.d),
            (0.26 * s.w, 0.22 * s.h, 0.52 * s.d),
            about("y", sx * 18.0),
            "cloth",
        )
        yield Part(
            "ellipsoid",
            (sx * 0.36 * s.w, 0.13 * s.h, 0.47 * s.d),
            (0.18 * s.w, 0.18 * s.h, 0.04 * s.d),
            slot="cloth_second",
            solid=False,
        )


FORMS = {"Bed": bed, "Pillow": pillow, "Cloth": cloth, "Towel": towel, "HandTowel": towel, "TeddyBear": teddy}
