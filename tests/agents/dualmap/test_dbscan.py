"""The largest cluster of DBSCAN, against the definition by all pairs."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.agents.dualmap.cloud import largest_cluster


def by_all_pairs(points: np.ndarray, radius_m: float, least: int) -> np.ndarray:
    """Labels of DBSCAN as it is defined, clusters in the order of their first core points; -1 is noise."""
    near = ((points[:, None] - points[None]) ** 2).sum(axis=2) <= radius_m * radius_m
    core = near.sum(axis=1) >= least
    labels, clusters = np.full(len(points), -1), 0
    for start in np.flatnonzero(core):
        if labels[start] >= 0:
            continue
        labels[start], waiting = clusters, [start]
        while waiting:
            for j in np.flatnonzero(near[waiting.pop()] & (labels < 0)):
                labels[j] = clusters
                if core[j]:
                    waiting.append(j)
        clusters += 1
    return labels


@given(
    st.integers(0, 2**32 - 1), st.integers(1, 90), st.integers(1, 12), st.tuples(*3 * [st.sampled_from([0.0, 0.05, 0.4, 1.2])])
)
def test_the_largest_cluster_is_that_of_the_definition(seed, count, least, extent):
    rng = np.random.default_rng(seed)
    blobs = rng.random((4, 3))[rng.integers(0, 4, count)]
    points = (blobs + 0.15 * rng.standard_normal((count, 3))) * extent
    labels = by_all_pairs(points, 0.1, least)
    wanted = [] if labels.max() < 0 else np.flatnonzero(labels == np.bincount(labels[labels >= 0]).argmax())
    assert largest_cluster(points, 0.1, least).tolist() == list(wanted)


def test_noise_has_no_cluster_and_a_border_point_belongs_to_the_first_that_reaches_it():
    row = np.c_[np.arange(30) * 0.09, np.zeros((30, 2))]
    assert not len(largest_cluster(row, 0.1, 10))
    assert not len(largest_cluster(np.zeros((0, 3)), 0.1, 10))
    left = np.c_[np.linspace(-0.045, 0.0, 10), np.zeros((10, 2))]
    between, right = np.array([[0.1, 0.0, 0.0]]), [0.2, 0.0, 0.0] - left
    assert largest_cluster(np.concatenate([left, between, right]), 0.1 + 1e-9, 10).tolist() == list(range(11))
    assert largest_cluster(np.concatenate([right, between, left]), 0.1 + 1e-9, 10).tolist() == list(range(11))
    assert largest_cluster(np.concatenate([left, right]), 0.1, 10).tolist() == list(range(10))


@pytest.mark.parametrize("axis", range(3))
def test_clusters_do_not_hang_on_the_axis_that_they_lie_along(axis):
    points = np.random.default_rng(0).random((200, 3)) * np.roll([2.0, 0.3, 0.01], axis)
    turned = np.roll(points, 1, axis=1)
    assert largest_cluster(points, 0.1, 5).tolist() == largest_cluster(turned, 0.1, 5).tolist()
