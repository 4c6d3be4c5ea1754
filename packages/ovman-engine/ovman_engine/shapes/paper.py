"""Books, newspapers, rolls and boxes of paper."""

from __future__ import annotations

from collections.abc import Iterator

from ovman_engine.shapes.part import Part, about, lathe, rod, span
from ovman_engine.shapes.subject import Subject


def book(s: Subject) -> Iterator[Part]:
    """Lying: two covers, a block of pages set in, a spine along one long side."""
    cover = min(0.004, 0.16 * s.h)
    inset = 0.004 + 0.01 * s.style.fraction("inset")
    yield span((-s.x, 0, -s.z), (s.x, cover, s.z), "main")
    yield span((-s.x, s.h - cover, -s.z), (s.x, s.h, s.z), "main")
    yield span((-s.x + cover, cover, -s.z + inset), (s.x - inset, s.h - cover, s.z - inset), "pages")
    yield span((-s.x, 0, -s.z), (-s.x + cover, s.h, s.z), "main", bevel=0.3 * cover, solid=False)
    yield span((-0.72 * s.x, s.h - cover, -0.1 * s.d), (0.72 * s.x, s.h + 0.0004, 0.36 * s.d), "picture", solid=False)
    yield span((-0.6 * s.x, s.h - cover, -0.34 * s.d), (0.6 * s.x, s.h + 0.0004, -0.24 * s.d), "accent", solid=False)


def newspaper(s: Subject) -> Iterator[Part]:
    """Folded sheets, the fold along the longer side."""
    if s.elongation > 2.0 and min(s.w, s.d) < 2.2 * s.h + 0.03:
        along_x = s.along_x
        start, end = ((-s.x, s.h / 2, 0), (s.x, s.h / 2, 0)) if along_x else ((0, s.h / 2, -s.z), (0, s.h / 2, s.z))
        across = s.d if along_x else s.w
        roll = rod(start, end, s.h / 2, "pages")
        yield roll.but(size=(s.h, roll.size[1], across) if along_x else (across, roll.size[1], s.h))
        return
    layers = 4
    for i in range(layers):
        shift = 0.012 * s.style.uniform(f"shift {i}", 0, 1) if i else 0.0
        yield span(
            (-s.x + shift, i * s.h / layers, -s.z + shift), (s.x - shift, (i + 0.92) * s.h / layers, s.z), "pages", solid=i == 0
        )
    yield span((-0.9 * s.x, 0.9 * s.h, -0.9 * s.z), (0.9 * s.x, s.h, -0.66 * s.z), "dark", solid=False)
    yield span((0.1 * s.x, 0.9 * s.h, -0.5 * s.z), (0.86 * s.x, s.h, 0.3 * s.z), "picture", solid=False)


def tissue_box(s: Subject) -> Iterator[Part]:
    """Yield a tissue box."""
    body = 0.6 * s.h
    yield span((-s.x, 0, -s.z), (s.x, body, s.z), "main", bevel=0.004)
    yield span((-0.995 * s.x - 0.0004, 0.15 * body, -1.002 * s.z), (0.995 * s.x, 0.8 * body, 1.002 * s.z), "picture", solid=False)
    yield span((-0.6 * s.x, body - 0.004, -0.4 * s.z), (0.6 * s.x, body + 0.001, 0.4 * s.z), "dark", kind="cylinder", solid=False)
    for i in range(5):
        turn = about("y", 72.0 * i + 20.0) @ about("x", 18.0)
        yield Part("leaf", (0, body - 0.01, 0), (0.7 * s.x, s.h - body, 0.2 * s.z), turn, "pale", solid=False)


def paper_roll(s: Subject) -> Iterator[Part]:
    """Yield a roll on end with a hollow core."""
    core = 0.28 * s.x
    ring = [(core, 0), (s.x, 0), (s.x, s.h), (core, s.h), (core, 0)]
    yield span((-s.x, 0, -s.z), (s.x, s.h, s.z), drawn=False, kind="cylinder")
    yield lathe(ring, slot="main", stretch=(1.0, s.z / s.x), solid=False)
    tube_ring = [(0.8 * core, 0.001), (core, 0.001), (core, s.h - 0.001), (0.8 * core, s.h - 0.001), (0.8 * core, 0.001)]
    yield lathe(tube_ring, slot="second", stretch=(1.0, s.z / s.x), solid=False)


def foil(s: Subject) -> Iterator[Part]:
    """Yield a carton along x with a printed side and a strip of foil."""
    yield span((-s.x, 0, -s.z), (s.x, s.h, 0.94 * s.z), "main", bevel=0.002)
    yield span((-0.9 * s.x, 0.15 * s.h, 0.9 * s.z), (0.9 * s.x, 0.85 * s.h, 0.96 * s.z), "picture", solid=False)
    yield span((-0.95 * s.x, 0.1 * s.h, 0.9 * s.z), (0.95 * s.x, 0.2 * s.h, s.z), "metal", solid=False)


FORMS = {
    "PaperTowelRoll": paper_roll,
    "ToiletPaper": paper_roll,
    "AluminumFoil": foil,
    "Book": book,
    "Newspaper": newspaper,
    "TissueBox": tissue_box,
}
