"""Statues: a plinth and a figure."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ovman_engine.shapes.part import Part, about, bar, lathe, rod, span, tube
from ovman_engine.shapes.subject import Subject


def statue(s: Subject) -> Iterator[Part]:
    """Yield a plinth and one of a few figures, by asset and by how upright it is.

    Figures are a bust, a standing figure, an animal, a bird and an abstract one.
    """
    st = s.style
    plinth = 0.09 * s.h
    form = st.choice("plinth", ("box", "cylinder"))
    yield span((-s.x, 0, -s.z), (s.x, plinth, s.z), "second", kind=form, bevel=0.05 * plinth)
    slender = s.slenderness
    if slender > 1.5:
        figure = st.choice("figure", (_bust, _standing, _abstract, _bird, _flame))
    else:
        figure = st.choice("figure", (_animal, _bird, _knot, _animal) if slender < 1.1 else (_animal, _bird, _bust))
    yield from figure(s, plinth)


def _bust(s: Subject, low: float) -> Iterator[Part]:
    high = s.h - low
    yield lathe(
        [(0, low), (0.3 * s.w, low), (0.18 * s.w, low + 0.12 * high), (0, low + 0.14 * high)],
        slot="main",
        solid=False,
        stretch=(1.0, s.d / s.w),
    )
    yield Part("cushion", (0, low + 0.3 * high, 0), (s.w * 0.96, 0.34 * high, 0.8 * s.d), slot="main", ratio=0.7)
    yield rod((0, low + 0.38 * high, -0.03 * s.d), (0, low + 0.66 * high, 0.0), 0.15 * min(s.w, s.d), "main", solid=False)
    yield Part("ellipsoid", (0, s.h - 0.22 * high, 0.02 * s.d), (0.46 * s.w, 0.44 * high, 0.6 * s.d), slot="main")
    yield Part("ellipsoid", (0, s.h - 0.25 * high, 0.32 * s.d), (0.08 * s.w, 0.14 * high, 0.14 * s.d), slot="main", solid=False)
    yield Part("ellipsoid", (0, s.h - 0.14 * high, -0.05 * s.d), (0.52 * s.w, 0.28 * high, 0.62 * s.d), slot="main", solid=False)
    for sx in (-1, 1):
        yield Part(
            "ellipsoid", (sx * 0.22 * s.w, s.h - 0.26 * high, 0), (0.06 * s.w, 0.12 * high, 0.12 * s.d), slot="main", solid=False
        )


def _standing(s: Subject, low: float) -> Iterator[Part]:
    high = s.h - low
    raised = s.style.chance("raised arm", 0.5)
    for sx in (-1, 1):
        yield rod(
            (sx * 0.16 * s.w, low, 0.05 * s.d * sx),
            (sx * 0.1 * s.w, low + 0.46 * high, 0),
            0.09 * s.w,
            "main",
            kind="frustum",
            ratio=1.5,
            solid=False,
        )
        yield Part(
            "ellipsoid",
            (sx * 0.17 * s.w, low + 0.02 * high, 0.14 * s.d),
            (0.2 * s.w, 0.05 * high, 0.5 * s.d),
            slot="main",
            solid=False,
        )
        up = raised and sx > 0
        hand = (sx * 0.46 * s.w, low + (0.92 if up else 0.42) * high, 0.2 * s.d)
        elbow = (sx * 0.42 * s.w, low + (0.74 if up else 0.56) * high, 0)
        yield tube([(sx * 0.22 * s.w, low + 0.74 * high, 0), elbow, hand], 0.055 * s.w, "main", solid=False)
    yield Part("cushion", (0, low + 0.6 * high, 0), (0.52 * s.w, 0.36 * high, 0.6 * s.d), slot="main", ratio=0.7, solid=False)
    yield rod((0, low + 0.74 * high, 0), (0, low + 0.86 * high, 0), 0.08 * s.w, "main", solid=False)
    yield Part("ellipsoid", (0, s.h - 0.09 * high, 0.02 * s.d), (0.28 * s.w, 0.18 * high, 0.5 * s.d), slot="main", solid=False)
    yield span((-0.4 * s.w, low, -0.4 * s.d), (0.4 * s.w, s.h, 0.4 * s.d), drawn=False, kind="cylinder")


def _animal(s: Subject, low: float) -> Iterator[Part]:
    """Yield a four-legged animal in profile along the longer side."""
    st = s.style
    along_x = s.along_x
    u, v = (s.x, s.z) if along_x else (s.z, s.x)
    high = s.h - low

    def at(a: float, y: float, b: float = 0.0) -> tuple[float, float, float]:
        return (a, y, b) if along_x else (b, y, a)

    belly = low + 0.36 * high
    neck = st.uniform("neck", 0.1, 0.3)
    for a in (-0.55, 0.5):
        for b in (-0.45, 0.45):
            yield rod(
                at(a * u, low, b * v),
                at(a * u * 0.94, belly + 0.1 * high, b * v * 0.8),
                0.16 * v,
                "main",
                kind="frustum",
                ratio=1.4,
                solid=False,
            )
    yield Part("ellipsoid", at(-0.02 * u, belly + 0.14 * high), at(1.4 * u, 0.36 * high, 1.5 * v), slot="main", solid=False)
    yield span(at(-0.8 * u, low, -0.8 * v), at(0.8 * u, belly + 0.3 * high, 0.8 * v), drawn=False)
    head = at(0.72 * u, s.h - 0.17 * high)
    yield rod(at(0.45 * u, belly + 0.2 * high), head, 0.3 * v, "main", kind="frustum", ratio=0.7, solid=False)
    yield Part("ellipsoid", head, at(0.44 * u, 0.22 * high, 0.9 * v), slot="main")
    yield Part("ellipsoid", at(0.9 * u, s.h - 0.21 * high), at(0.2 * u, 0.13 * high, 0.5 * v), slot="main", solid=False)
    for b in (-0.3, 0.3):
        yield rod(
            at(0.68 * u, s.h - 0.1 * high, b * v),
            at(0.62 * u, s.h, 1.3 * b * v),
            0.13 * v,
            "main",
            kind="frustum",
            ratio=0.2,
            solid=False,
        )
    yield tube(
        [
            at(-0.68 * u, belly + 0.2 * high),
            at(-0.9 * u, belly + (0.2 + neck) * high),
            at(-0.97 * u, belly + (0.1 + 1.5 * neck) * high),
        ],
        0.1 * v,
        "main",
        solid=False,
    )


def _bird(s: Subject, low: float) -> Iterator[Part]:
    high = s.h - low
    along_x = s.along_x
    u, v = (s.x, s.z) if along_x else (s.z, s.x)

    def at(a: float, y: float, b: float = 0.0) -> tuple[float, float, float]:
        return (a, y, b) if along_x else (b, y, a)

    lean = about("z", 28.0) if along_x else about("x", -28.0)
    yield Part("ellipsoid", at(0, low + 0.42 * high), at(1.5 * u, 0.46 * high, 1.7 * v), lean, "main")
    yield Part("ellipsoid", at(0.45 * u, s.h - 0.16 * high), at(0.66 * u, 0.32 * high, 1.1 * v), slot="main")
    yield rod(
        at(0.7 * u, s.h - 0.17 * high),
        at(0.99 * u, s.h - 0.2 * high),
        0.05 * high,
        "accent",
        kind="frustum",
        ratio=0.1,
        solid=False,
    )
    for b in (-1, 1):
        yield Part(
            "ellipsoid",
            at(-0.12 * u, low + 0.45 * high, b * 0.72 * v),
            at(1.1 * u, 0.3 * high, 0.4 * v),
            lean,
            "second",
            solid=False,
        )
        yield rod(at(0.05 * u, low, b * 0.3 * v), at(0.0, low + 0.28 * high, b * 0.3 * v), 0.03 * high, "accent", solid=False)
    yield bar(at(-0.5 * u, low + 0.3 * high), at(-0.98 * u, low + 0.14 * high), 0.5 * v, 0.05 * high, "second", solid=False)


def _abstract(s: Subject, low: float) -> Iterator[Part]:
    """Yield a twisted stack."""
    count = s.style.whole("blocks", 4, 7)
    twist = s.style.uniform("twist", 10, 32)
    step = (s.h - low) / count
    for i in range(count):
        share = 0.66 - 0.34 * abs(2 * (i + 0.5) / count - 1) * s.style.uniform("waist", -0.6, 1.0)
        yield Part(
            "box",
            (0, low + (i + 0.5) * step, 0),
            (share * s.w, step * 1.001, share * s.d),
            about("y", twist * i),
            "main" if i % 2 else "accent",
            bevel=0.08 * step,
        )


def _flame(s: Subject, low: float) -> Iterator[Part]:
    """Two bands that wind around each other."""
    turns = s.style.uniform("turns", 0.8, 1.6)
    for phase in (0.0, np.pi):
        t = np.linspace(0, 1, 17)
        swell = np.sin(np.pi * t) ** 0.7 * 0.36
        angle = phase + 2 * np.pi * turns * t
        path = np.stack(
            [swell * s.w * np.cos(angle), low + (s.h - low - 0.09 * s.w) * t + 0.03 * s.w, swell * s.d * np.sin(angle)], axis=1
        )
        yield tube(path, 0.085 * min(s.w, s.d), "main" if phase else "accent", solid=False)
    yield span((-0.42 * s.w, low, -0.42 * s.d), (0.42 * s.w, s.h, 0.42 * s.d), drawn=False, kind="ellipsoid")


def _knot(s: Subject, low: float) -> Iterator[Part]:
    """Yield a row of rings along the longer side, linked."""
    along_x = s.along_x
    half, deep = (s.x, s.z) if along_x else (s.z, s.x)
    high = s.h - low
    count = max(1, round(2 * half / high * 1.3))
    wide = 2 * half / (1 + 0.72 * (count - 1))
    for i in range(count):
        u = -half + wide / 2 + 0.72 * wide * i
        tilt = (1 if i % 2 else -1) * s.style.uniform("tilt", 8, 26) if count > 1 else 0.0
        size = (wide, 0.5 * deep, high)
        turn = (about("y", tilt) if along_x else about("y", 90.0 + tilt)) @ about("x", 90.0)
        centre = (u, low + high / 2, 0) if along_x else (0, low + high / 2, u)
        yield Part(
            "torus", centre, size, turn, "main" if i % 2 else "accent", solid=False, ratio=s.style.uniform("band", 0.22, 0.4)
        )
    if along_x:
        yield span((-0.9 * half, low, -0.3 * deep), (0.9 * half, low + 0.9 * high, 0.3 * deep), drawn=False)
    else:
        yield span((-0.3 * deep, low, -0.9 * half), (0.3 * deep, low + 0.9 * high, 0.9 * half), drawn=False)


FORMS = {
    "Statue": statue,
}
