"""Cross-visit association: minimum-cost assignment with non-assignment (Eq. cost and Eq. pad of the paper)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike


@dataclass(frozen=True, slots=True)
class Association:
    """Which instance of visit 1 is which instance of visit 2. Every index is in exactly one pair or unmatched tuple.

    Attributes:
        pairs: (i, j), i an index into visit 1 and j into visit 2, sorted.
        unmatched_1: The other indices into visit 1, sorted.
        unmatched_2: The other indices into visit 2, sorted.
    """

    pairs: tuple[tuple[int, int], ...]
    unmatched_1: tuple[int, ...]
    unmatched_2: tuple[int, ...]


def associate(
    p_1: ArrayLike,
    p_2: ArrayLike,
    f_1: ArrayLike | None = None,
    f_2: ArrayLike | None = None,
    *,
    gate_m: float,
    feature_scale_m: float,
    disagreement: ArrayLike | None = None,
) -> Association:
    """Match the instances of two visits at minimum cost, some of them with nothing (Eq. cost, Eq. pad).

    Leaving i and j unmatched costs gate_m together, so no pair of cost >= gate_m is returned. The result does not depend on the
    order in which the instances are listed: among equal optima the one that the solver finds for the instances in lexicographic
    order of (x, z, features) is taken.

    Args:
        p_1: (N, 2) floor-plane positions (x, z) in metres, world frame.
        p_2: (M, 2) floor-plane positions of the second visit.
        f_1: (N, K) unit feature vectors, or None for arms that are given positions, whose cost is distance alone.
        f_2: (M, K) unit feature vectors, None if f_1 is.
        gate_m: gamma, metres.
        feature_scale_m: lambda, metres.
        disagreement: (N, M), at least 0: how unlike two instances look, in place of one minus the inner product of their
            features.

    Raises:
        ValueError: A wrong shape, a value that is not finite, features of one visit only, a disagreement below 0, or gate_m <= 0.
    """
    if not gate_m > 0:
        raise ValueError(f"gate_m must be positive, not {gate_m}")
    if (f_1 is None) != (f_2 is None):
        raise ValueError("features must be given for both visits or for neither")
    p_1, p_2 = positions(p_1, "p_1"), positions(p_2, "p_2")
    n, m = len(p_1), len(p_2)
    unlike = None if disagreement is None else _disagreement(disagreement, (n, m))
    keys_1, keys_2 = p_1, p_2
    features_1 = features_2 = None
    if f_1 is not None and f_2 is not None:
        features_1, features_2 = _features(f_1, "f_1", n), _features(f_2, "f_2", m)
        keys_1, keys_2 = np.hstack([p_1, features_1]), np.hstack([p_2, features_2])

    pairs: list[tuple[int, int]] = []
    if n and m:
        order_1, order_2 = _lexicographic(keys_1), _lexicographic(keys_2)
        cost = cost_matrix(
            p_1[order_1],
            p_2[order_2],
            None if features_1 is None else features_1[order_1],
            None if features_2 is None else features_2[order_2],
            feature_scale_m=feature_scale_m,
            disagreement=None if unlike is None else unlike[np.ix_(order_1, order_2)],
        )
        from scipy.optimize import linear_sum_assignment  # takes half a second, and most jobs need none

        rows, columns = linear_sum_assignment(pad_costs(cost, gate_m))
        pairs = sorted(
            (int(order_1[i]), int(order_2[j]))
            for i, j in zip(rows, columns, strict=True)
            # A pair that costs exactly the gate ties with leaving both unmatched: never beneficial.
            if i < n and j < m and cost[i, j] < gate_m
        )
    matched_1, matched_2 = {i for i, _ in pairs}, {j for _, j in pairs}
    return Association(
        pairs=tuple(pairs),
        unmatched_1=tuple(i for i in range(n) if i not in matched_1),
        unmatched_2=tuple(j for j in range(m) if j not in matched_2),
    )


def cost_matrix(
    p_1: np.ndarray,
    p_2: np.ndarray,
    f_1: np.ndarray | None = None,
    f_2: np.ndarray | None = None,
    *,
    feature_scale_m: float,
    disagreement: np.ndarray | None = None,
) -> np.ndarray:
    """Return (N, M) metres: distance plus feature_scale_m times (1 - inner product of features) or times `disagreement`.

    Eq. cost.
    """
    cost = distances(p_1, p_2)
    if disagreement is not None:
        return cost + feature_scale_m * disagreement
    if f_1 is not None and f_2 is not None:
        # Rounding can put the inner product of two equal unit vectors above one; a cost is never negative.
        cost = cost + feature_scale_m * np.clip(1.0 - f_1 @ f_2.T, 0.0, None)
    return cost


def pad_costs(cost: np.ndarray, gate_m: float) -> np.ndarray:
    """Return the square (N+M, N+M) matrix of Eq. pad: one dummy per row and column at D = gate_m / 2.

    Elsewhere it has a prohibitive finite cost, which exceeds that of leaving everything unmatched, (N + M) D: no optimum has it.
    """
    n, m = cost.shape
    dummy = gate_m / 2
    prohibitive = 2 * (n + m + 1) * dummy
    square = np.full((n + m, n + m), prohibitive)
    square[:n, :m] = cost
    square[:n, m:][np.diag_indices(n)] = dummy
    square[n:, :m][np.diag_indices(m)] = dummy
    square[n:, m:] = 0.0
    return square


def distances(p_1: np.ndarray, p_2: np.ndarray) -> np.ndarray:
    """Return (N, M) floor-plane distances in metres between the rows of (N, 2) and (M, 2)."""
    gaps: np.ndarray = np.hypot(p_1[:, None, 0] - p_2[None, :, 0], p_1[:, None, 1] - p_2[None, :, 1])
    return gaps


def positions(points: ArrayLike, name: str = "positions") -> np.ndarray:
    """Return any sequence of floor-plane points, also the empty one, as (N, 2) float64.

    Raises:
        ValueError: Another shape, or a value that is not finite; the message has `name`.
    """
    array = np.asarray(points, dtype=np.float64)
    if array.size == 0:
        array = array.reshape(0, 2)
    if array.ndim != 2 or array.shape[1] != 2:
        raise ValueError(f"{name} must have the shape (N, 2), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds a value that is not finite")
    return array


def _features(features: ArrayLike, name: str, count: int) -> np.ndarray:
    array = np.asarray(features, dtype=np.float64)
    if array.size == 0 and count == 0:
        return array.reshape(0, array.shape[1] if array.ndim == 2 else 0)
    if array.ndim != 2 or len(array) != count:
        raise ValueError(f"{name} must have the shape ({count}, K), not {array.shape}")
    if not np.isfinite(array).all():
        raise ValueError(f"{name} holds a value that is not finite")
    return array


def _disagreement(disagreement: ArrayLike, shape: tuple[int, int]) -> np.ndarray:
    array = np.asarray(disagreement, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(f"disagreement must have the shape {shape}, not {array.shape}")
    if not (np.isfinite(array).all() and (array >= 0).all()):
        raise ValueError("disagreement holds a value that is not finite or is below 0")
    return array


def _lexicographic(rows: np.ndarray) -> np.ndarray:
    return np.lexsort(rows.T[::-1])
