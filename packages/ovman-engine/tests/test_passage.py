"""Reachable positions and their components, against SciPy's sparse matrices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components

from ovman_engine.bodies import passage
from ovman_engine.plan import floorplan
from ovman_engine.world.world import World


def by_scipy(count: int, edges: np.ndarray) -> np.ndarray:
    """The same partition, as labels."""
    graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
    return connected_components(graph, directed=False)[1]


def same_partition(a: np.ndarray, b: np.ndarray) -> bool:
    return len({*zip(a.tolist(), b.tolist(), strict=True)}) == len({*a.tolist()}) == len({*b.tolist()})


@pytest.mark.parametrize("density", [0.0, 0.2, 0.5, 1.0, 3.0])
def test_components_are_those_of_scipy(density: float) -> None:
    rng = np.random.default_rng(int(density * 10))
    for count in (1, 2, 7, 60, 400):
        edges = rng.integers(0, count, (int(density * count), 2))
        assert same_partition(passage.joined(count, edges), by_scipy(count, edges))


def test_a_chain_in_any_order_is_one_component() -> None:
    count = 5000
    order = np.random.default_rng(0).permutation(count)
    chain = np.stack([order[:-1], order[1:]], axis=1)
    assert not passage.joined(count, chain).any()


@pytest.mark.parametrize("name", ["FloorPlan7", "FloorPlan201"])
@pytest.mark.parametrize("portion", [passage.PORTION, 37])
def test_positions_are_those_of_sparse_matrices(name: str, portion: int, monkeypatch: pytest.MonkeyPatch) -> None:
    world = World(floorplan.read(name), seed=0)
    monkeypatch.setattr(passage, "PORTION", portion)
    found = world.reachable()

    def components(
        obstacles: passage.Obstacles, points: np.ndarray, number: np.ndarray, near: np.ndarray, free: np.ndarray
    ) -> np.ndarray:
        boxes = csr_array(np.unpackbits(near, axis=1, count=len(obstacles.reach)).astype(bool))
        pairs = [(number[:-1], number[1:]), (number[:, :-1], number[:, 1:])]
        edges = np.concatenate([np.stack([a.ravel(), b.ravel()], axis=1) for a, b in pairs])
        edges = edges[free[edges].all(axis=1)]
        edge, box = (boxes[edges[:, 0]] + boxes[edges[:, 1]]).nonzero()
        a, b = points[edges[edge, 0]], points[edges[edge, 1]]
        hit = obstacles.boxes.sweeps(a, b, box, obstacles.low, obstacles.high) < obstacles.reach[box]
        return by_scipy(len(points), np.delete(edges, np.unique(edge[hit]), axis=0))

    monkeypatch.setattr(passage, "_components", components)
    expected = world.reachable()
    assert len(found) > 20
    assert np.array_equal(np.array(found), np.array(expected))
