"""Tables and desks. Drawers, doors and shelves that are objects of their own are left to those."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.fronts import closed_block, doors, drawers
from ovman_engine.shapes.part import Part, lathe, span
from ovman_engine.shapes.seating import legs
from ovman_engine.shapes.subject import Subject


def _round(s: Subject) -> bool:
    return s.style.chance("round top", 0.3) and 0.8 < s.w / s.d < 1.25 and not s.inserts


def _top(s: Subject, thick: float, slot: str = "main") -> Iterator[Part]:
    if _round(s):
        yield span((-s.x, s.h - thick, -s.z), (s.x, s.h, s.z), slot, kind="cylinder", segments=40)
    else:
        yield span((-s.x, s.h - thick, -s.z), (s.x, s.h, s.z), slot, bevel=s.style.uniform("edge", 0.002, 0.012))


def _apron(s: Subject, top: float, inset: float, height: float, slot: str = "trim") -> Iterator[Part]:
    thick = 0.02
    x, z = s.x - inset, s.z - inset
    for sign in (-1, 1):
        yield span((-x, top - height, sign * z - thick / 2), (x, top, sign * z + thick / 2), slot, solid=False)
        yield span((sign * x - thick / 2, top - height, -z), (sign * x + thick / 2, top, z), slot, solid=False)


def _support(s: Subject, top: float, inset: float, width: float) -> Iterator[Part]:
    """Yield the support of a table top: four legs, a pedestal, trestles or a sled."""
    form = s.style.choice("support", ("legs", "legs", "legs", "splayed", "trestle", "sled", "pedestal"))
    if s.inserts and form in ("pedestal", "trestle"):
        form = "legs"
    if form == "pedestal" and max(s.w, s.d) < 1.4:
        foot = 0.62 * min(s.x, s.z)
        thick = max(0.035, 0.1 * foot)
        yield lathe(
            [
                (0, 0),
                (foot, 0),
                (foot, 0.02),
                (thick * 1.6, 0.07 * top + 0.03),
                (thick, 0.3 * top),
                (thick, 0.85 * top),
                (2 * thick, top),
                (0, top),
            ],
            slot="trim",
        )
    elif form == "trestle" and s.w > 0.7:
        for sx in (-1, 1):
            x = sx * (s.x - max(0.12 * s.w, inset))
            yield span((x - width, 0, -s.z + inset), (x + width, 0.05, s.z - inset), "trim", bevel=0.006)
            yield span((x - width * 0.7, 0, -0.13 * s.d), (x + width * 0.7, top, 0.13 * s.d), "trim", bevel=0.006)
            yield span((x - width * 0.8, top - 0.05, -s.z + inset), (x + width * 0.8, top, s.z - inset), "trim", solid=False)
        beam = s.x - max(0.12 * s.w, inset)
        yield span((-beam, 0.3 * top, -0.025), (beam, 0.3 * top + 0.07, 0.025), "trim", solid=False)
    elif form == "sled":
        bar_m = width * 0.6
        for sx in (-1, 1):
            x = sx * (s.x - inset - bar_m / 2)
            for sz in (-1, 1):
                z = sz * (s.z - inset - bar_m / 2)
                yield span((x - bar_m / 2, 0, z - bar_m / 2), (x + bar_m / 2, top, z + bar_m / 2), "metal")
            for y in (0.0, top - bar_m):
                yield span((x - bar_m / 2, y, -s.z + inset), (x + bar_m / 2, y + bar_m, s.z - inset), "metal", solid=False)
    else:
        splay = 0.25 * inset + 0.03 if form == "splayed" else 0.0
        yield from legs(s, top, max(0.0, inset - splay), width, splay, "trim")
        if form != "splayed":
            yield from _apron(s, top, inset + width * 0.6, min(0.09, 0.2 * s.h))


def table(s: Subject) -> Iterator[Part]:
    """Dining tables, coffee tables and side tables alike: a top, what carries it, and whatever hangs below."""
    st = s.style
    if s.h < 0.16 or s.hung:
        yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), "main", bevel=0.01)
        return
    thick = min(st.uniform("thick", 0.018, 0.045), 0.12 * s.h)
    top = s.h - thick
    yield from _top(s, thick)
    low = min((i.y0 for i in s.inserts if i.kind != "shelf"), default=top)
    if low < 0.3 * s.h:
        yield from _case(s, top)
        return
    width = min(st.uniform("width", 0.03, 0.065), 0.14 * min(s.w, s.d))
    inset = (0.17 if _round(s) else st.uniform("inset", 0.0, 0.12)) * min(s.w, s.d)
    if low < top:
        yield from closed_block(s, top)
        inset = 0.0
        yield from legs(s, top, 0.0, width, 0.0, "trim")
    else:
        yield from _support(s, top, inset, width)
    if s.h > 0.3 and not s.inserts and st.chance("lower shelf", 0.35):
        y = st.uniform("lower", 0.18, 0.35) * s.h
        yield span(
            (-s.x + inset, y, -s.z + inset),
            (s.x - inset, y + 0.018, s.z - inset),
            "second",
            kind="cylinder" if _round(s) else "box",
            bevel=0.003,
        )


def _case(s: Subject, top: float) -> Iterator[Part]:
    """Yield a closed piece on short feet: sides, back, and a block behind every front."""
    foot = min(0.1, 0.12 * s.h)
    thick = 0.02
    yield from legs(s, foot, 0.0, 0.04, 0.0, "trim", solid=False)
    for sx in (-1, 1):
        low, high = sorted((sx * s.x, sx * (s.x - thick)))
        yield span((low, foot if s.style.chance("short sides", 0.5) else 0.0, -s.z), (high, top, s.z - 0.01), "main")
    yield span((-s.x, foot, -s.z), (s.x, top, -s.z + 0.012), "main")
    yield from closed_block(s, top)
    yield span((-s.x + thick, foot, -s.z), (s.x - thick, foot + 0.02, s.z - 0.03), "main")


def side_table(s: Subject) -> Iterator[Part]:
    """Yield a side table."""
    st = s.style
    if s.inserts or st.chance("plain", 0.45) or s.h < 0.35 or _round(s):
        yield from table(s)
        return
    thick = st.uniform("thick", 0.018, 0.032)
    top = s.h - thick
    foot = st.uniform("foot", 0.08, 0.45) * s.h
    width = min(0.04, 0.12 * min(s.w, s.d))
    yield from _top(s, thick)
    yield from legs(s, top, 0.0, width, 0.0, "trim")
    yield span((-s.x + 0.005, foot, -s.z + 0.005), (s.x - 0.005, top, s.z - 0.03), "main", bevel=0.003)
    area = (-s.x + width, s.x - width, foot + 0.01, top - 0.01)
    if top - foot > 0.3 and st.chance("doors", 0.4):
        yield from doors(area, s.z - 0.03, s.style, 2 if s.w > 0.6 else 1)
    else:
        yield from drawers(area, s.z - 0.03, s.style, rows=max(1, round((top - foot) / 0.19)), columns=1 if s.w < 0.8 else 2)


def desk(s: Subject) -> Iterator[Part]:
    """Yield a desk."""
    st = s.style
    thick = st.uniform("thick", 0.02, 0.038)
    if s.h < 0.3:
        yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), "main", bevel=min(0.008, s.h / 4))
        return
    top = s.h if s.h < 1.0 else 0.76
    body = Subject(s.type, s.w, top, s.d, st, tuple(i for i in s.inserts if i.y1 < top + 0.02))
    yield span((-s.x, top - thick, -s.z), (s.x, top, s.z), "main", bevel=0.006)
    under = top - thick
    fronts = [i for i in body.inserts if i.kind != "shelf"]
    width = 0.045
    if fronts:
        yield from closed_block(body, under)
    elif not body.inserts:
        side = st.choice("pedestals", ((-1,), (1,), (-1, 1)) if s.w > 1.3 else ((-1,), (1,)))
        for sx in side:
            share = 0.32 * s.w if len(side) == 1 else 0.26 * s.w
            low, high = sorted((sx * (s.x - 0.03), sx * (s.x - 0.03 - share)))
            yield span((low, 0.06, -s.z + 0.03), (high, under, s.z - 0.05), "second", bevel=0.003)
            yield from drawers((low, high, 0.07, under - 0.01), s.z - 0.05, st, rows=st.whole("rows", 3, 4), columns=1)
    if st.chance("panel ends", 0.4):
        for sx in (-1, 1):
            low, high = sorted((sx * s.x, sx * (s.x - 0.028)))
            yield span((low, 0, -s.z + 0.01), (high, under, s.z - 0.02), "main", bevel=0.003)
    else:
        yield from legs(Subject(s.type, s.w, top, s.d, st), under, 0.0, width, 0.0, "trim")
    yield span((-s.x + 0.03, under - 0.28, -s.z + 0.04), (s.x - 0.03, under, -s.z + 0.055), "main", solid=False)
    if s.h > top + 0.1:
        hutch = min(0.3, 0.45 * s.d)
        for x in (-s.x, -0.01, s.x - 0.02):
            yield span((x, top, -s.z), (x + 0.02, s.h, -s.z + hutch), "main", bevel=0.002, solid=abs(x + 0.01) > 0.1)
        yield span((-s.x, top, -s.z), (s.x, s.h, -s.z + 0.012), "main")
        levels = max(1, round((s.h - top) / 0.33))
        for i in range(1, levels + 1):
            y = top + (s.h - top) * i / levels
            yield span((-s.x, y - 0.02, -s.z), (s.x, y, -s.z + hutch), "main", bevel=0.002, solid=i == levels)


def stand(s: Subject) -> Iterator[Part]:
    """Yield a low piece under a television: open compartments, doors or drawers."""
    st = s.style
    thick = 0.025
    foot = st.uniform("foot", 0.04, 0.14)
    top = s.h - thick
    yield span((-s.x, top, -s.z), (s.x, s.h, s.z), "main", bevel=0.005)
    yield from legs(s, foot, 0.02, 0.05, 0.0, "trim", solid=False)
    yield span((-s.x, foot, -s.z), (s.x, foot + 0.022, s.z - 0.01), "main", bevel=0.003)
    for sx in (-1, 1):
        low, high = sorted((sx * s.x, sx * (s.x - thick)))
        yield span((low, foot, -s.z), (high, top, s.z - 0.01), "main", bevel=0.003)
    yield span((-s.x, foot, -s.z), (s.x, top, -s.z + 0.012), "second")
    if s.inserts:
        yield from closed_block(s, top)
        return
    inner = s.x - thick
    third = inner * st.uniform("third", 0.3, 0.4)
    yield span((-third - 0.01, foot, -s.z), (-third + 0.01, top, s.z - 0.02), "main", solid=False)
    yield span((third - 0.01, foot, -s.z), (third + 0.01, top, s.z - 0.02), "main", solid=False)
    middle = (foot + top) / 2
    yield span((-third, middle - 0.01, -s.z), (third, middle + 0.01, s.z - 0.03), "main", solid=False)
    yield span(
        (-third + 0.06, middle + 0.012, -s.z + 0.05), (third - 0.06, middle + 0.065, s.z - 0.08), "dark", bevel=0.004, solid=False
    )
    for sx in (-1, 1):
        low, high = sorted((sx * inner, sx * third))
        yield span((low, foot, -s.z), (high, top, s.z - 0.035), "main")
        area = (low + 0.006, high - 0.006, foot + 0.03, top - 0.008)
        if st.chance("doors", 0.5):
            yield from doors(area, s.z - 0.035, st, 1)
        else:
            yield from drawers(area, s.z - 0.035, st, rows=2, columns=1)


FORMS = {"DiningTable": table, "CoffeeTable": table, "SideTable": side_table, "Desk": desk, "TVStand": stand}
