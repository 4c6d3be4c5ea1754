"""Distances between the agent's axis and boxes, against sampling."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine.bodies.footprint import Boxes
from ovman_engine.plan.floorplan import Box, rotation_matrix

coordinate = st.floats(-2, 2, allow_nan=False)
length = st.floats(0.01, 1, allow_nan=False)
angle = st.floats(0, 360, allow_nan=False)
LOW, HIGH = 0.2, 1.6


@st.composite
def boxes(draw: st.DrawFn, upright: bool) -> Box:
    euler = np.array([0.0 if upright else draw(angle), draw(angle), 0.0 if upright else draw(angle)])
    centre = np.array([draw(coordinate), draw(coordinate), draw(coordinate)])
    return Box(centre, np.array([draw(length), draw(length), draw(length)]), rotation_matrix(euler))


def sampled(box: Box, point: np.ndarray) -> float:
    heights = np.linspace(LOW, HIGH, 1401)
    axis = np.stack([np.full_like(heights, point[0]), heights, np.full_like(heights, point[1])], axis=1)
    outside = np.maximum(np.abs((axis - box.centre) @ box.rotation) - box.half, 0.0)
    return float(np.linalg.norm(outside, axis=1).min())


@given(st.booleans().flatmap(lambda upright: boxes(upright)), coordinate, coordinate)
def test_distance_of_a_point_is_that_of_the_nearest_point_of_the_axis(box: Box, x: float, z: float) -> None:
    point = np.array([x, z])
    found = float(Boxes.of([box]).distances(point[None], LOW, HIGH, within=np.inf)[0, 0])
    assert abs(found - sampled(box, point)) < 1e-3


@given(st.booleans().flatmap(lambda upright: boxes(upright)), coordinate, coordinate, coordinate, coordinate)
def test_a_sweep_comes_as_close_as_its_closest_point(box: Box, x: float, z: float, dx: float, dz: float) -> None:
    start, end = np.array([x, z]), np.array([x, z]) + 0.25 * np.array([dx, dz])
    columns = Boxes.of([box])
    found = float(columns.sweeps(start[None], end[None], np.array([0]), LOW, HIGH)[0])
    points = start + np.linspace(0, 1, 201)[:, None] * (end - start)
    nearest = float(columns.distances(points, LOW, HIGH, within=np.inf).min())
    assert found <= nearest + 1.7e-3
    assert found >= nearest - 5e-3
    ends = columns.distances(np.stack([start, end]), LOW, HIGH, within=np.inf)[:, 0]
    assert found >= ends.sum() / 2 - np.linalg.norm(end - start) / 2 - 1e-9


def test_beyond_the_asked_distance_an_answer_may_be_smaller_but_never_near() -> None:
    tilted = Box(np.array([0.0, 0.9, 0.0]), np.array([0.5, 0.01, 0.5]), rotation_matrix(np.array([45.0, 30.0, 0.0])))
    points = np.stack(np.meshgrid(np.linspace(-2, 2, 21), np.linspace(-2, 2, 21)), axis=-1).reshape(-1, 2)
    exact = Boxes.of([tilted]).distances(points, LOW, HIGH, within=np.inf)
    bounded = Boxes.of([tilted]).distances(points, LOW, HIGH, within=0.3)
    near = exact < 0.3
    assert np.array_equal(exact[near], bounded[near])
    assert (bounded[~near] >= 0.3).all() and (bounded <= exact + 1e-12).all()


def test_what_hangs_over_the_head_is_as_far_as_it_is_high() -> None:
    lamp = Box(np.array([0.0, 2.3, 0.0]), np.array([0.2, 0.1, 0.2]), np.eye(3))
    assert np.isclose(Boxes.of([lamp]).distances(np.zeros((1, 2)), LOW, HIGH, within=5.0)[0, 0], 2.2 - HIGH)
