"""From a detector's masks to those that DualMap observes: none twice, none too small, each pixel in one of them at most."""

from __future__ import annotations

import numpy as np

from ovman.models.settings.baselines import DualmapObservation


def histogram(rgb: np.ndarray, bins: int) -> np.ndarray:
    """Counts of pixels (N, 3) uint8 in `bins` equal bins of each channel, (3 * bins,)."""
    values = np.concatenate([np.bincount(rgb[:, channel], minlength=256) for channel in range(3)])
    cells = np.arange(256) * bins // 256 + np.arange(3)[:, None] * bins
    return np.bincount(cells.ravel(), values, minlength=3 * bins)


def filtered(
    masks: np.ndarray, rgb: np.ndarray, min_mask_px: float, constants: DualmapObservation
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The masks that are observed, of masks (N, H, W) bool in a picture rgb (H, W, 3).

    Returns which of the N they are (M,), the masks (M, H, W) bool, disjoint, and the same before anything was subtracted. Masks
    below min_mask_px pixels go; of two that are the same the larger stays; one that overlaps a larger one of the same colours is
    merged into it; what still overlaps is the smaller one's; what that leaves below min_mask_px goes.
    """
    sizes = np.array([np.count_nonzero(mask) for mask in masks], np.int64)
    kept = np.flatnonzero(sizes >= max(min_mask_px, 1))
    kept = kept[np.argsort(-sizes[kept], kind="stable")]
    masks, sizes = masks[kept], sizes[kept]
    flat = masks.reshape(len(masks), int(np.prod(masks.shape[1:])))
    shared = _shared(masks, sizes)
    alone = _first_of_same(shared, sizes, constants.same_iou)
    flat, kept, shared = flat[alone], kept[alone], shared[np.ix_(alone, alone)]
    flat, kept = _merged(flat, kept, shared, rgb.reshape(-1, 3), constants)
    whole = flat.reshape(len(flat), *masks.shape[1:])
    own, taken = flat.copy(), np.zeros(flat.shape[1:], bool)
    for mask in own[::-1]:
        mask &= ~taken
        taken |= mask
    enough = np.array([np.count_nonzero(mask) for mask in own], np.int64) >= max(min_mask_px, 1)
    return kept[enough], own[enough].reshape(-1, *masks.shape[1:]), whole[enough]


def _shared(masks: np.ndarray, sizes: np.ndarray) -> np.ndarray:
    """(N, N) pixels that masks (N, H, W) of these sizes (at least 1) have in common."""
    shared = np.diag(sizes)
    spans = [
        [(int(hit[0]), int(hit[-1]) + 1) for hit in map(np.flatnonzero, (mask.any(axis=1), mask.any(axis=0)))] for mask in masks
    ]
    for i, (rows, columns) in enumerate(spans):
        for j, (other_rows, other_columns) in enumerate(spans[:i]):
            top, bottom = max(rows[0], other_rows[0]), min(rows[1], other_rows[1])
            left, right = max(columns[0], other_columns[0]), min(columns[1], other_columns[1])
            if top < bottom and left < right:
                both = masks[i, top:bottom, left:right] & masks[j, top:bottom, left:right]
                shared[i, j] = shared[j, i] = np.count_nonzero(both)
    return shared


def _first_of_same(shared: np.ndarray, sizes: np.ndarray, same_iou: float) -> np.ndarray:
    """Which masks, the largest first, are not the same as a larger one that is kept."""
    kept: list[int] = []
    for i in range(len(sizes)):
        union = sizes[kept] + sizes[i] - shared[i, kept]
        if not (shared[i, kept] > same_iou * union).any():
            kept.append(i)
    return np.array(kept, np.int64)


def _merged(
    flat: np.ndarray, kept: np.ndarray, shared: np.ndarray, colours: np.ndarray, constants: DualmapObservation
) -> tuple[np.ndarray, np.ndarray]:
    """Masks (N, H * W), the largest first, without those that were merged into a larger one; and which of them they are."""
    meet = np.argwhere(np.triu(shared > 0, 1)).tolist()
    if not meet:
        return flat, kept
    flat = flat.copy()
    histograms = {i: histogram(colours[flat[i]], constants.colour_bins) for i in {k for pair in meet for k in pair}}
    gone: set[int] = set()
    for i, j in meet:
        if i in gone or j in gone:
            continue
        a, b = histograms[i], histograms[j]
        if a @ b > constants.same_colours * np.sqrt((a @ a) * (b @ b)):
            flat[i] |= flat[j]
            gone.add(j)
    left = [i for i in range(len(flat)) if i not in gone]
    order = sorted(left, key=lambda i: -np.count_nonzero(flat[i]))
    return flat[order], kept[order]
