"""Beds, four-posters and bunks. The head is at -z, the back."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, column, rod, span
from ovman_engine.shapes.seating import legs
from ovman_engine.shapes.subject import Subject

USUAL_M = 0.57
"""Height of the lying surface if nothing lies on the bed."""
BUNK_M = 1.2
"""From this height on, a bed is a bunk: it has only posts below."""
POSTER_M = 1.2
"""Parts that rise this far above the mattress are posts."""
GUARD_M = 0.22


def bed(s: Subject) -> Iterator[Part]:
    """Yield a bed: frame and legs, headboard, mattress, duvet; a four-poster or a bunk if it is tall."""
    lying = min((i.y0 for i in s.inserts if i.kind == "rest"), default=min(USUAL_M, 0.64 * s.h))
    lying = min(max(lying, 0.25 * s.h), s.h - 0.03)
    if lying > BUNK_M:
        yield from _bunk(s, lying)
        return
    st = s.style
    frame = st.uniform("frame", 0.2, 0.3) * min(lying / 0.55, 1.2)
    foot = min(st.uniform("foot", 0.05, 0.12), 0.5 * frame)
    head = st.uniform("head", 0.04, 0.09)
    top = s.h
    if s.h - lying > POSTER_M:
        top = lying + 0.55
        yield from _posts(s)
    yield span((-s.x, foot, -s.z + head), (s.x, frame, s.z), "main", bevel=0.012)
    yield from legs(s, foot + 0.02, 0.02, 0.07, 0.0, "trim", solid=False)
    yield from _headboard(s, lying, top, head)
    board = lying + st.uniform("footboard", -0.05, 0.14) if st.chance("has footboard", 0.4) else frame
    if board > frame:
        yield span((-s.x, 0, s.z - 0.05), (s.x, min(board, s.h), s.z), "main", bevel=0.012)
    yield from _bedding(s, lying, frame, -s.z + head, s.z - 0.06)


def _headboard(s: Subject, lying: float, top: float, head: float) -> Iterator[Part]:
    """Yield a panel, slats, or upholstered, `head` thick, up to height `top`."""
    form = s.style.choice("headboard", ("panel", "slats", "soft", "buttoned"))
    slot = "cloth_second" if form in ("soft", "buttoned") else "main"
    yield span((-s.x, 0, -s.z), (s.x, top, -s.z + head), drawn=form != "slats", slot=slot, bevel=0.015)
    if form == "slats":
        for sx in (-1, 1):
            low, high = sorted((sx * s.x, sx * (s.x - 0.06)))
            yield span((low, 0, -s.z), (high, top, -s.z + head), "main", bevel=0.006, solid=False)
        for y in (min(lying, top - 0.15), top - 0.07):
            yield span((-s.x, y, -s.z + 0.01), (s.x, y + 0.065, -s.z + head - 0.01), "main", bevel=0.006, solid=False)
        count = max(5, round(s.w / 0.14))
        for i in range(1, count):
            x = -s.x + s.w * i / count
            low = min(lying, top - 0.15)
            yield span((x - 0.014, low, -s.z + 0.02), (x + 0.014, top - 0.02, -s.z + head - 0.02), "main", solid=False)
    elif form == "buttoned" and top - lying > 0.1:
        count = max(3, round(s.w / 0.3))
        for i in range(count):
            for row in range(2):
                high = (top - lying) / 2
                x0 = -s.x + s.w * i / count
                first = (x0 + 0.003, lying + row * high, -s.z + head - 0.02)
                yield span(
                    first,
                    (x0 + s.w / count - 0.003, lying + (row + 1) * high, -s.z + head + 0.03),
                    "cloth_second",
                    kind="cushion",
                    ratio=0.3,
                    solid=False,
                )
    elif form == "panel" and top - lying > 0.15:
        corner = (-s.x * 0.9, lying, -s.z + head - 0.01)
        yield span(corner, (s.x * 0.9, top - 0.06, -s.z + head + 0.008), "second", bevel=0.006, solid=False)


def _bedding(s: Subject, lying: float, frame: float, first: float, last: float) -> Iterator[Part]:
    """Mattress, duvet with its edge turned back, a throw, and pillows if none lies on the bed, from `first` to `last` along z.

    `lying` is the height of the lying surface.
    """
    st = s.style
    yield span((-s.x + 0.03, frame, first), (s.x - 0.03, lying, last), drawn=False)
    yield span((-s.x + 0.03, frame, first), (s.x - 0.03, lying - 0.03, last), "pale", kind="cushion", ratio=0.12, solid=False)
    depth = min(0.42, 0.2 * s.d)
    if not s.inserts and s.h > lying + 0.2:
        count = 1 if s.w < 1.25 else 2
        wide = (s.w - 0.16) / count
        for i in range(count):
            at = (-s.x + 0.08 + wide * (i + 0.5), lying + 0.03, first + depth / 2 + 0.04)
            size = (wide * 0.92, 0.15, depth)
            yield Part("cushion", at, size, about("x", -16.0), "cloth", solid=False, ratio=0.55)
    turn = first + depth + st.uniform("turn", 0.06, 0.3)
    hang = frame - st.uniform("hang", 0.0, 0.12)
    low, high = (-s.x + 0.005, hang, turn), (s.x - 0.005, lying, last + 0.01)
    yield span(low, high, "cloth_second", kind="cushion", ratio=0.1, solid=False)
    low, high = (-s.x + 0.005, lying - 0.04, turn - 0.02), (s.x - 0.005, lying + 0.02, turn + 0.24)
    yield span(low, high, "accent", kind="cushion", ratio=0.25, solid=False)
    if st.chance("throw", 0.5):
        far = turn + 0.62 * (last - turn)
        low, high = (-s.x, frame - 0.04, far), (s.x, lying + 0.012, far + 0.4)
        yield span(low, high, "accent", kind="cushion", ratio=0.1, solid=False)


def _posts(s: Subject) -> Iterator[Part]:
    """Four posts to the top, rails between them and cloth drawn aside at the head."""
    thick = 0.05
    for sx in (-1, 1):
        for sz in (-1, 1):
            x, z = sx * (s.x - thick / 2), sz * (s.z - thick / 2)
            high = s.h if sz < 0 else s.h - 0.004
            yield column(x, z, 0, high, thick / 2, "main", kind="box")
        x = sx * (s.x - thick / 2)
        yield span((x - 0.015, s.h - 0.05, -s.z), (x + 0.015, s.h - 0.01, s.z), "main", solid=False)
        z = sx * (s.z - thick / 2)
        yield span((-s.x, s.h - 0.05, z - 0.015), (s.x, s.h - 0.01, z + 0.015), "main", solid=False)
        yield column(x * 0.96, -s.z + 0.16, 0.4, s.h - 0.05, 0.05, "pale", kind="frustum", ratio=0.6, solid=False)


def _bunk(s: Subject, lying: float) -> Iterator[Part]:
    """Yield a deck on four posts with a guard rail around it and a ladder at its foot."""
    thick = 0.06
    rail = min(lying + GUARD_M, s.h - 0.03)
    for sx in (-1, 1):
        for sz in (-1, 1):
            x, z = sx * (s.x - thick / 2), sz * (s.z - thick / 2)
            high = s.h if sz < 0 else max(rail, s.h - 0.004)
            yield column(x, z, 0, high, thick / 2, "main", kind="box")
        low, high = sorted((sx * s.x, sx * (s.x - 0.03)))
        yield span((low, lying - 0.26, -s.z), (high, lying - 0.12, s.z), "main", solid=False)
        yield span((low, rail - 0.07, -s.z), (high, rail, s.z if sx < 0 else 0.45 * s.z), "main", solid=False)
        low, high = sorted((sx * s.z, sx * (s.z - 0.03)))
        yield span((-s.x, rail - 0.07, low), (s.x, rail, high), "main", solid=False)
    deck = lying - 0.2
    yield span((-s.x, deck, -s.z), (s.x, deck + 0.03, s.z), "main")
    for z in (0.55 * s.z, 0.9 * s.z):
        yield rod((s.x - 0.02, 0, z), (s.x - 0.02, rail, z), 0.018, "main", solid=False)
    for i in range(1, int(lying / 0.28) + 1):
        y = 0.28 * i
        yield rod((s.x - 0.02, y, 0.55 * s.z), (s.x - 0.02, y, 0.9 * s.z), 0.014, "main", solid=False)
    yield from _bedding(s, lying, deck + 0.03, -s.z + 0.06, s.z - 0.06)


FORMS = {"Bed": bed}
