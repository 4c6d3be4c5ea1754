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
    disagreement: np.ndarray | None = None,
) -> Association:
    """Match the instances of two visits at minimum cost, some of them with nothing (Eq. cost, Eq. pad).

    Leaving i and j unmatched costs gate_m together, so no pair of cost >= gate_m is returned. The result does not depend on the
    order in which the instances are listed: among equal optima the one that the solver finds for the instances in lexicographic
    order of (x, z, features) is taken.

    Args:
        p_1: (N, 2) floor-plane positions (x, z) in metres, world frame.
        p_2: (M, 2) positions of the second visit.
        f_1: (N, K) unit feature vectors, or None for arms that are given positions, whose cost is distance alone.
        f_2: (M, K) unit feature vectors, None if f_1 is.
        gate_m: gamma, metres.
        feature_scale_m: lambda, metres.
        disagreement: (N, M), at least 0: how unlike two instances look, in place of one minus the inner product of their
            features.
    """
    p_1, p_2 = positions(p_1, "p_1"), positions(p_2, "p_2")
    n, m = len(p_1), len(p_2)
    pairs: list[tuple[int, int]] = []
    if n and m:
        (order_1, p_1, f_1), (order_2, p_2, f_2) = _sort(p_1, f_1), _sort(p_2, f_2)
        if disagreement is not None:
            disagreement = disagreement[np.ix_(order_1, order_2)]
        cost = cost_matrix(p_1, p_2, f_1, f_2, feature_scale_m=feature_scale_m, disagreement=disagreement)
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


def _sort(points: np.ndarray, features: ArrayLike | None) -> tuple[np.ndarray, np.ndarray, np.ndarray | None]:
    """Return the lexicographic order of (x, z, features), and both arrays in it."""
    of = None if features is None else np.asarray(features, np.float64)
    order = np.lexsort((points if of is None else np.hstack([points, of])).T[::-1])
    return order, points[order], None if of is None else of[order]
