"""Shapes: within their boxes and filling them, closed, reproducible, and suitable for collisions."""

from __future__ import annotations

from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine import shapes
from ovman_engine.plan import counters, floorplan
from ovman_engine.shapes import part as parts_of
from ovman_engine.shapes.collision import Piece
from ovman_engine.shapes.fit import bounds
from ovman_engine.shapes.part import Part

INSIDE_M = 1e-3
ROUNDED_M = 2e-3
"""A faceted ellipsoid is drawn inside the true one, which collides."""
FOLIAGE_M = 0.02
SOME_SCENES = (
    "FloorPlan3",
    "FloorPlan16",
    "FloorPlan215",
    "FloorPlan227",
    "FloorPlan305",
    "FloorPlan326",
    "FloorPlan403",
    "FloorPlan424",
)


@pytest.fixture(scope="module")
def forms() -> list[tuple[floorplan.FloorPlan, floorplan.SimObject, tuple[Part, ...]]]:
    """Every object of some scenes, without floors, and its compound."""
    plans = [floorplan.load(name) for name in SOME_SCENES]
    return [(plan, o, shapes.compound(o, plan)) for plan in plans for o in plan.objects if o.type != "Floor"]


def closed(faces: np.ndarray) -> bool:
    """Whether every edge occurs once in each direction: the mesh is closed and wound one way."""
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]).astype(np.int64)
    forth = np.unique(edges[:, 0] << 32 | edges[:, 1])
    back = np.unique(edges[:, 1] << 32 | edges[:, 0])
    return len(forth) == len(edges) and np.array_equal(forth, back)


def volume(vertices: np.ndarray, faces: np.ndarray) -> float:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6)


def areas(vertices: np.ndarray, faces: np.ndarray) -> np.ndarray:
    a, b, c = (vertices[faces[:, i]] for i in range(3))
    return np.linalg.norm(np.cross(b - a, c - a), axis=1) / 2


def reach(piece: Piece) -> np.ndarray:
    """Points that span the bounds of a collision piece."""
    kind = piece[0]
    if kind == "hull":
        return piece[1]
    if kind == "sphere":
        return piece[1] + np.array([[-1], [1]]) * np.full(3, piece[2])
    if kind == "box":
        half = np.abs(piece[3]) @ piece[2]
    elif kind == "ellipsoid":
        half = np.sqrt(piece[3] ** 2 @ piece[2] ** 2)
    elif kind == "capsule":
        half = np.abs(piece[4][:, 1]) * piece[3] + piece[2]
    else:
        assert kind == "cylinder"
        axis = piece[4][:, 1]
        half = np.abs(axis) * piece[3] + piece[2] * np.sqrt(np.clip(1 - axis**2, 0, 1))
    return piece[1] + np.stack([-half, half])


def test_what_is_drawn_fills_the_box_and_stays_in_it(forms):
    wrong = []
    for plan, o, parts in forms:
        low, high = bounds(parts)
        out = max((-o.box.half - low).max(), (high - o.box.half).max())
        off = max(np.abs(-o.box.half - low).max(), np.abs(high - o.box.half).max())
        if o.type in shapes.LOOSE:  # boards lie below their boxes, under what rests on them
            sides = [0, 2]
            out = max((-o.box.half - low)[sides].max(), (high - o.box.half).max())
            off = max(np.abs(-o.box.half - low)[sides].max(), np.abs(high - o.box.half)[sides].max())
        if out > INSIDE_M or off > (FOLIAGE_M if o.type == "HousePlant" else INSIDE_M):
            wrong.append((plan.name, o.object_id, round(out, 4), round(off, 4)))
    assert not wrong


def test_collisions_happen_inside_what_is_drawn(forms):
    """Everything can be bumped into, and nothing outside of what is drawn."""
    wrong = []
    for plan, o, parts in forms:
        low, high = bounds(parts)
        points = np.concatenate([reach(c) for p in parts for c in shapes.collision(p)])
        if (points < low - ROUNDED_M).any() or (points > high + ROUNDED_M).any() or not np.isfinite(points).all():
            wrong.append((plan.name, o.object_id))
    assert not wrong


def test_meshes_are_closed_outward_and_without_slivers(forms):
    for _, o, parts in forms:
        for part in parts:
            vertices, faces = shapes.mesh(part)
            assert np.isfinite(vertices).all()
            assert closed(faces), (o.object_id, part.kind)
            assert volume(vertices, faces) > 0, (o.object_id, part.kind)
            assert areas(vertices, faces).min() > 1e-13, (o.object_id, part.kind)


sides = st.floats(0.004, 3.0)


@given(
    st.sampled_from(["box", "cylinder", "frustum", "ellipsoid", "cushion", "capsule", "torus", "leaf"]),
    st.tuples(sides, sides, sides),
    st.floats(0.15, 1.0),
    st.floats(0.0, 0.05),
)
def test_a_primitive_is_closed_and_within_its_size(kind, size, ratio, bevel):
    part = Part(kind, (0.3, -1.0, 2.0), size, parts_of.about("y", 30.0), ratio=ratio, bevel=bevel)
    vertices, faces = shapes.mesh(part)
    local = (vertices - part.centre) @ part.rotation
    assert closed(faces)
    assert volume(vertices, faces) > 0
    if kind != "leaf":
        assert np.abs(local).max(axis=0) == pytest.approx(part.size / 2, rel=1e-6)


def test_an_unknown_kind_or_an_empty_part_is_refused():
    with pytest.raises(ValueError, match="unknown kind"):
        Part("blob", (0, 0, 0), (1, 1, 1))
    with pytest.raises(ValueError, match="positive size"):
        Part("box", (0, 0, 0), (1, 0, 1))


# --- counters ---------------------------------------------------------------------------------------------------------------

COUNTERS = [(name, o.object_id) for name in floorplan.names() for o in floorplan.load(name).objects if o.type == "CounterTop"]


def test_runs_of_a_counter_touch_its_box_on_all_sides_do_not_overlap_and_leave_the_agent_its_place():
    for name, object_id in COUNTERS:
        plan = floorplan.load(name)
        runs, box = counters.runs(plan, plan[object_id]), counters.footprint(plan[object_id])
        assert not any(r.holds(plan.start[0], plan.start[2], counters.BODY_M) for r in runs), (name, object_id)
        assert 1 <= len(runs) <= 3
        assert min(r.x0 for r in runs) == pytest.approx(box.x0, abs=1e-6)
        assert min(r.z0 for r in runs) == pytest.approx(box.z0, abs=1e-6)
        assert max(r.x1 for r in runs) == pytest.approx(box.x1, abs=1e-6)
        assert max(r.z1 for r in runs) == pytest.approx(box.z1, abs=1e-6)
        for a, b in combinations(runs, 2):
            common = a.overlap(b)
            assert common is None or (common.x1 - common.x0) * (common.z1 - common.z0) < 1e-9


def test_a_counter_is_cut_out_where_a_sink_is():
    plan = floorplan.load("FloorPlan1")
    sink = next(o for o in plan.objects if o.type == "Sink")
    for counter in (o for o in plan.objects if o.type == "CounterTop"):
        for part in shapes.compound(counter, plan):
            low, high = bounds([part])
            low, high = low + counter.box.centre, high + counter.box.centre
            middle = sink.box.centre
            covers = low[0] < middle[0] < high[0] and low[2] < middle[2] < high[2]
            assert not (covers and high[1] > middle[1] + 0.05)


@given(st.lists(st.tuples(*[st.floats(-2, 2)] * 4), max_size=3))
def test_a_rectangle_less_others_keeps_exactly_what_is_left(corners):
    rect = counters.Rect(-1.0, -1.0, 1.0, 1.0)
    holes = tuple(counters.Rect(min(a, c), min(b, d), max(a, c), max(b, d)) for a, b, c, d in corners)
    pieces = counters.without(rect, holes)
    rng = np.random.default_rng(0)
    for x, z in rng.uniform(-1, 1, (60, 2)):
        inside_hole = any(h.holds(x, z) for h in holes)
        count = sum(p.holds(x, z) for p in pieces)
        near = any(min(abs(x - e) for e in (h.x0, h.x1)) < 2e-3 or min(abs(z - e) for e in (h.z0, h.z1)) < 2e-3 for h in holes)
        assert near or count == (0 if inside_hole else 1)
