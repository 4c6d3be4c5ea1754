"""Which objects of a map a noun means (the grounding stage of the reference agent)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike


def similarities(features: ArrayLike, noun: ArrayLike) -> np.ndarray:
    """s (N,): inner products of unit features (N, K) with the unit text embedding (K,) of a noun phrase.

    An instance's similarity does not depend on what else is in the map. Raises ValueError for a wrong shape or a value that is
    not finite.
    """
    f, q = np.asarray(features, dtype=np.float64), np.asarray(noun, dtype=np.float64)
    if not f.size:
        return np.zeros(0)
    if f.ndim != 2 or q.shape != f.shape[1:]:
        raise ValueError(f"features (N, K) and a noun (K,) of one encoder are needed, not {f.shape} and {q.shape}")
    if not (np.isfinite(f).all() and np.isfinite(q).all()):
        raise ValueError("features or noun hold a value that is not finite")
    # Not a matrix product, whose last bit depends on the row's place in the matrix.
    similarity: np.ndarray = (f * q).sum(axis=1)
    return similarity


def grounded(features: ArrayLike, noun: ArrayLike, similarity_margin: float) -> tuple[int, ...]:
    """G_v: the sorted indices i of a map with s_i >= max_j s_j - similarity_margin; none for an empty map.

    features (N, K), noun (K,): unit vectors of one encoder; similarity_margin: delta_g >= 0, without unit. A near-tie does not
    discard the right instance. Raises ValueError as ``similarities`` does, and for a negative margin. Source: the paper's
    grounding stage.
    """
    if not similarity_margin >= 0:
        raise ValueError(f"similarity_margin must be at least 0, not {similarity_margin}")
    s = similarities(features, noun)
    return tuple(np.flatnonzero(s >= s.max() - similarity_margin).tolist()) if len(s) else ()
