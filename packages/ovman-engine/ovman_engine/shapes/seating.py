"""Chairs, stools, armchairs, sofas and other seats. Back at -z."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, bar, column, rod, span
from ovman_engine.shapes.subject import Subject

SEAT, SEAT_M = 0.49, 0.51
"""Height of a chair's seat relative to the chair, and at most, metres: objects that AI2-THOR recorded on chairs rest there."""
LOWEST_SEAT = 0.3
"""Chairs are solid from this height to the seat, so that nothing that was recorded on a lower seat falls through."""


def legs(
    s: Subject, top: float, inset: float, width: float, splay: float = 0.0, slot: str = "trim", solid: bool = True
) -> Iterator[Part]:
    """Four legs from the floor to `top`, their feet `inset` from the edges of the footprint, tops `splay` further in; metres."""
    style = s.style.choice("legs", ("square", "round", "tapered"))
    for sx in (-1, 1):
        for sz in (-1, 1):
            foot = (sx * (s.x - inset - width / 2), 0.0, sz * (s.z - inset - width / 2))
            head = (foot[0] - sx * splay, top, foot[2] - sz * splay)
            if style == "square":
                yield bar(foot, head, width, slot=slot, solid=solid)
            elif style == "round":
                yield rod(foot, head, width / 2, slot, solid=solid)
            else:
                yield rod(foot, head, width / 2, slot, kind="frustum", ratio=1.7, solid=solid)


def chair(s: Subject) -> Iterator[Part]:
    """Yield a chair."""
    st = s.style
    width = st.uniform("leg width", 0.028, 0.048)
    top = min(SEAT * s.h, SEAT_M)
    board = st.uniform("board", 0.022, 0.045)
    soft = st.chance("upholstered", 0.45)
    lean = st.uniform("lean", 0.03, 0.09) * s.d / 0.5
    if st.chance("swivel", 0.16):
        yield from _swivel(s, top)
        return
    back_foot = -s.z + lean + width / 2
    front = s.z - width / 2
    posts = s.x - width / 2
    for sx in (-1, 1):
        if st.chance("round legs", 0.4):
            yield rod((sx * posts, 0, front), (sx * posts, top - board / 2, front), width / 2, "main")
            yield rod((sx * posts, 0, back_foot), (sx * posts, top, back_foot), width / 2, "main")
        else:
            yield bar((sx * posts, 0, front), (sx * posts, top - board / 2, front), width, slot="main")
            yield bar((sx * posts, 0, back_foot), (sx * posts, top, back_foot), width, slot="main")
        yield bar((sx * posts, top, back_foot), (sx * posts, s.h, -s.z + width / 2), width, slot="main", solid=False)
    low = top - board
    yield span((-s.x, low, back_foot - width / 2), (s.x, top, s.z), "main", bevel=0.006)
    yield span((-s.x, LOWEST_SEAT * s.h, back_foot), (s.x, low, s.z), drawn=False)
    if soft:
        yield span(
            (-s.x + 0.012, top - 0.01, back_foot + width),
            (s.x - 0.012, top + 0.04, s.z - 0.008),
            "cloth",
            kind="cushion",
            ratio=0.3,
            solid=False,
        )
    for sx in (-1, 1):
        yield span((sx * posts - width / 3, low - 0.06, back_foot), (sx * posts + width / 3, low, front), "main", solid=False)
    for z in (back_foot, front):
        yield span((-posts, low - 0.06, z - width / 3), (posts, low, z + width / 3), "main", solid=False)
    if st.chance("stretcher", 0.6):
        for sx in (-1, 1):
            yield rod((sx * posts, 0.17 * s.h, back_foot), (sx * posts, 0.17 * s.h, front), width / 3.4, "main", solid=False)
        yield rod((-posts, 0.17 * s.h, 0), (posts, 0.17 * s.h, 0), width / 3.4, "main", solid=False)

    def depth(y: float) -> float:
        return back_foot + (y - top) / (s.h - top) * (-s.z + width / 2 - back_foot)

    def rail(low_y: float, high_y: float, thick: float, slot: str = "main") -> Part:
        return bar((0, low_y, depth(low_y)), (0, high_y, depth(high_y)), 2 * posts, thick, slot, solid=False)

    yield bar((0, top, back_foot), (0, s.h, -s.z + width / 2), s.w, width, drawn=False)
    head = s.h - st.uniform("head rail", 0.05, 0.11)
    yield rail(head, s.h - 0.004, width * 0.7)
    form = st.choice("back", ("slats", "slats", "ladder", "panel", "cushion", "spindles"))
    foot = top + st.uniform("gap", 0.05, 0.14)
    if form in ("slats", "spindles"):
        yield rail(foot, foot + 0.035, width * 0.6)
        count = st.whole("slats", 3, 5) if form == "slats" else st.whole("slats", 6, 8)
        for i in range(count):
            x = posts * (2 * (i + 1) / (count + 1) - 1)
            ends = (x, foot + 0.02, depth(foot + 0.02)), (x, head + 0.01, depth(head + 0.01))
            if form == "slats":
                yield bar(*ends, min(0.05, posts / count), 0.012, solid=False)
            else:
                yield rod(*ends, 0.007, "main", solid=False)
    elif form == "ladder":
        count = st.whole("rungs", 2, 4)
        for i in range(count):
            y = foot + (head - foot) * i / count
            yield rail(y, y + min(0.06, (head - foot) / count * 0.55), width * 0.5)
    elif form == "panel":
        yield rail(foot, head + 0.01, 0.014, "second")
    else:
        yield rail(foot, head + 0.01, 0.02)
        middle = (foot + head) / 2
        yield Part(
            "cushion",
            (0, middle, depth(middle) + 0.02),
            (2 * posts - width, head - foot, 0.06),
            about("x", -4.0),
            "cloth",
            solid=False,
            ratio=0.35,
        )


def _swivel(s: Subject, top: float) -> Iterator[Part]:
    """Yield an office chair: star base on castors, gas spring, upholstered shell, arms if it is wide enough."""
    reach = min(s.x, s.z)
    for i in range(5):
        angle = np.pi / 2 + 2 * np.pi * i / 5
        tip = np.array([np.cos(angle) * (s.x - 0.03), 0.06, np.sin(angle) * (s.z - 0.03)])
        yield bar((0, 0.1, 0), tip, 0.035, 0.03, "metal", solid=False)
        yield Part("ellipsoid", (tip[0], 0.03, tip[2]), (0.055, 0.06, 0.055), slot="dark", solid=False)
    yield span((-s.x, 0, -s.z), (s.x, 0.1, s.z), drawn=False, kind="frustum", ratio=0.3)
    yield column(0, 0, 0.08, top - 0.06, 0.03, "metal")
    yield span((-s.x * 0.9, LOWEST_SEAT * s.h, -s.z * 0.8), (s.x * 0.9, top - 0.04, s.z * 0.9), drawn=False)
    yield span((-s.x * 0.9, top - 0.08, -s.z * 0.8), (s.x * 0.9, top + 0.03, s.z), "cloth", kind="cushion", ratio=0.3)
    yield bar((0, top - 0.06, -s.z * 0.62), (0, top + 0.14, -s.z + 0.05), 0.08, 0.02, "dark", solid=False)
    yield Part("cushion", (0, (top + 0.1 + s.h) / 2, -s.z + 0.05), (s.w * 0.86, s.h - top - 0.1, 0.1), slot="cloth", ratio=0.3)
    if s.style.chance("arms", 0.6):
        for sx in (-1, 1):
            yield rod((sx * (s.x - 0.03), top - 0.04, 0), (sx * (s.x - 0.03), top + 0.2, -0.02), 0.014, "dark", solid=False)
            yield span(
                (sx * (s.x - 0.03) - 0.03, top + 0.19, -reach * 0.5),
                (sx * (s.x - 0.03) + 0.03, top + 0.22, reach * 0.5),
                "dark",
                bevel=0.01,
                solid=False,
            )


def stool(s: Subject) -> Iterator[Part]:
    """Yield a stool."""
    st = s.style
    board = st.uniform("board", 0.03, 0.05)
    width = st.uniform("leg width", 0.025, 0.04)
    round_seat = st.chance("round seat", 0.6)
    splay = st.uniform("splay", 0.02, 0.05)
    low = s.h - board
    inset = 0.0
    if st.chance("pedestal", 0.2) and s.h > 0.6:
        yield span((-s.x, 0, -s.z), (s.x, 0.03, s.z), "metal", kind="cylinder")
        yield column(0, 0, 0.03, low - 0.03, 0.026, "metal")
        yield span(
            (-s.x * 0.6, s.h * 0.3, -s.z * 0.6),
            (s.x * 0.6, s.h * 0.3 + 0.02, s.z * 0.6),
            "metal",
            kind="torus",
            ratio=0.12,
            solid=False,
        )
    else:
        inset = 0.12 * min(s.w, s.d) if round_seat else 0.0
        yield from legs(s, low, max(0.0, inset - splay), width, splay, "main")
        for share in (0.3, 0.55) if s.h > 0.6 else (0.35,):
            x, z = (half - max(0.0, inset - splay) - width / 2 - splay * share for half in (s.x, s.z))
            y = low * share
            for sx in (-1, 1):
                yield rod((sx * x, y, -z), (sx * x, y, z), width / 3, "main", solid=False)
                yield rod((-x, y + 0.03, sx * z), (x, y + 0.03, sx * z), width / 3, "main", solid=False)
    if round_seat:
        yield span((-s.x, low, -s.z), (s.x, s.h - 0.012, s.z), "second", kind="cylinder")
        yield span((-s.x * 0.95, low + 0.01, -s.z * 0.95), (s.x * 0.95, s.h, s.z * 0.95), "cloth", kind="cylinder", solid=False)
    else:
        yield span((-s.x, low, -s.z), (s.x, s.h, s.z), "second", bevel=0.01)


def armchair(s: Subject) -> Iterator[Part]:
    """Yield an armchair."""
    yield from _upholstered(s, 1)


def sofa(s: Subject) -> Iterator[Part]:
    """Yield a sofa."""
    yield from _upholstered(s, s.style.choice("seats", (2, 3)) if s.w < 2.3 else s.style.choice("seats", (3, 3, 4)))


def _upholstered(s: Subject, seats: int) -> Iterator[Part]:
    st = s.style
    foot = st.uniform("foot", 0.05, 0.14)
    arm = min(st.uniform("arm", 0.11, 0.22), 0.2 * s.w)
    back = min(st.uniform("back", 0.16, 0.26), 0.28 * s.d)
    told = min((i.y0 for i in s.inserts if i.kind == "rest"), default=max(0.42, 0.42 * s.h))
    seat = min(max(told, 0.35 * s.h), 0.6 * s.h)
    rest = min(s.h - 0.05, seat + st.uniform("rest", 0.14, 0.26))
    roll = st.choice("arm form", ("square", "round", "track"))
    puff = st.uniform("puff", 0.18, 0.4)
    yield from legs(Subject(s.type, s.w - 0.04, s.h, s.d - 0.04, st), foot + 0.02, 0.0, 0.05, solid=False)
    yield span((-s.x, foot, -s.z), (s.x, seat - 0.14, s.z - 0.02), "cloth", bevel=0.012)
    for sx in (-1, 1):
        low, high = sorted((sx * s.x, sx * (s.x - arm)))
        if roll == "round":
            yield span((low + 0.01, foot, -s.z + 0.02), (high - 0.01, rest - arm / 2, s.z - 0.02), "cloth", bevel=0.015)
            yield rod(
                (sx * (s.x - arm / 2), rest - arm / 2, -s.z + 0.02),
                (sx * (s.x - arm / 2), rest - arm / 2, s.z),
                arm / 2,
                "cloth",
                solid=False,
            )
        elif roll == "square":
            yield span((low, foot, -s.z + 0.02), (high, rest, s.z), "cloth", bevel=0.03)
        else:
            yield span((low, foot, -s.z + 0.02), (high, rest, s.z), "cloth", kind="cushion", ratio=0.2)
    yield span((-s.x + 0.02, foot, -s.z), (s.x - 0.02, s.h - 0.03, -s.z + back), "cloth", bevel=0.04)
    inside = s.w - 2 * arm
    step = inside / seats
    lean = st.uniform("lean", 6.0, 14.0)
    for i in range(seats):
        x = -inside / 2 + i * step
        yield span(
            (x + 0.004, seat - 0.15, -s.z + back),
            (x + step - 0.004, seat, s.z - 0.005),
            "cloth_second",
            kind="cushion",
            ratio=puff * 0.7,
            solid=False,
        )
        height = s.h - seat + 0.02
        yield Part(
            "cushion",
            (x + step / 2, seat + height / 2 - 0.02, -s.z + back + 0.03),
            (step - 0.012, height, 0.17),
            about("x", -lean),
            "cloth_second",
            solid=False,
            ratio=puff,
        )
    yield span((-inside / 2, seat - 0.14, -s.z + back), (inside / 2, seat, s.z), "cloth", drawn=False)
    if st.chance("throw", 0.5) and seats > 1:
        for sx in (-1, 1):
            yield Part(
                "cushion",
                (sx * (inside / 2 - 0.2), seat + 0.16, -s.z + back + 0.17),
                (0.36, 0.34, 0.12),
                about("y", -sx * 18.0) @ about("x", -22.0),
                "accent",
                solid=False,
                ratio=0.5,
            )


def ottoman(s: Subject) -> Iterator[Part]:
    """Yield an ottoman."""
    st = s.style
    foot = st.uniform("foot", 0.04, 0.1) * min(1.0, s.h / 0.4)
    yield from legs(s, foot + 0.02, 0.02, 0.045, solid=False)
    yield span((-s.x, foot, -s.z), (s.x, s.h * 0.72, s.z), "cloth", bevel=0.02)
    yield span((-s.x, s.h * 0.66, -s.z), (s.x, s.h, s.z), "cloth_second", kind="cushion", ratio=st.uniform("puff", 0.15, 0.35))


def footstool(s: Subject) -> Iterator[Part]:
    """Yield a footstool."""
    yield from legs(s, s.h * 0.7, 0.0, 0.035, 0.01, "trim")
    yield span((-s.x, s.h * 0.62, -s.z), (s.x, s.h * 0.75, s.z), "main", bevel=0.008)
    yield span((-s.x, s.h * 0.72, -s.z), (s.x, s.h, s.z), "cloth", kind="cushion", ratio=0.3)


def dog_bed(s: Subject) -> Iterator[Part]:
    """Yield a dog's bed."""
    rim = 0.16 * min(s.w, s.d)
    yield span(
        (-s.x + rim / 2, 0, -s.z + rim / 2), (s.x - rim / 2, s.h * 0.45, s.z - rim / 2), "cloth_second", kind="cushion", ratio=0.3
    )
    for sx in (-1, 1):
        low, high = sorted((sx * s.x, sx * (s.x - rim)))
        yield span((low, 0, -s.z), (high, s.h, s.z), "cloth", kind="cushion", ratio=0.35)
    yield span((-s.x, 0, -s.z), (s.x, s.h, -s.z + rim), "cloth", kind="cushion", ratio=0.35)
    yield span((-s.x, 0, s.z - rim), (s.x, s.h * 0.6, s.z), "cloth", kind="cushion", ratio=0.35)


FORMS = {
    "Chair": chair,
    "Stool": stool,
    "ArmChair": armchair,
    "Sofa": sofa,
    "Ottoman": ottoman,
    "Footstool": footstool,
    "DogBed": dog_bed,
}
