"""From a detector's masks to those of DualMap's observations: no duplicates, none too small, disjoint."""

from __future__ import annotations

import numpy as np

from ovman.agents.dualmap.settings import DualmapObservation


def cells(rgb: np.ndarray, bins: int) -> np.ndarray:
    """(N,) the cell of pixels (N, 3) uint8 in a cube of `bins` equal bins a channel, in C order."""
    red, green, blue = (np.arange(256) * bins // 256)[rgb.T]
    found: np.ndarray = (red * bins + green) * bins + blue
    return found


def histogram(cells: np.ndarray, bins: int) -> np.ndarray:
    """Counts (3 * bins,) of pixels in the bins of each channel, one channel after the other; cells (N,): of `cells`."""
    # Pixels are counted once, in the cube, which is summed for each channel.
    cube = np.bincount(cells, minlength=bins**3).reshape(bins, bins, bins)
    return np.concatenate([cube.sum(axis=(1, 2)), cube.sum(axis=(0, 2)), cube.sum(axis=(0, 1))]).astype(float)


def filtered(
    masks: np.ndarray, rgb: np.ndarray, min_mask_px: float, constants: DualmapObservation
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The observed masks among masks (N, H, W) bool of a picture rgb (H, W, 3).

    Returns their indices (M,), the disjoint masks (M, H, W) bool, and the same masks before overlaps were removed. The steps:
    drop masks below min_mask_px pixels; of duplicates keep the larger; merge a mask into a larger one of the same colours that it
    overlaps; give remaining overlaps to the smaller mask; drop what is then below min_mask_px.
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
    """Indices of the masks, the largest first, that duplicate no larger kept one."""
    kept: list[int] = []
    for i in range(len(sizes)):
        union = sizes[kept] + sizes[i] - shared[i, kept]
        if not (shared[i, kept] > same_iou * union).any():
            kept.append(i)
    return np.array(kept, np.int64)


def _merged(
    flat: np.ndarray, kept: np.ndarray, shared: np.ndarray, colours: np.ndarray, constants: DualmapObservation
) -> tuple[np.ndarray, np.ndarray]:
    """Masks (M, H * W), the largest first, after merging masks into larger ones; and their indices."""
    meet = np.argwhere(np.triu(shared > 0, 1)).tolist()
    if not meet:
        return flat, kept
    flat = flat.copy()
    of = cells(colours, constants.colour_bins)
    histograms = {i: histogram(of[flat[i]], constants.colour_bins) for i in {k for pair in meet for k in pair}}
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
