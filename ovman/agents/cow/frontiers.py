"""Frontiers: free cells beside unknown ones, and one target for each cluster of them."""

from __future__ import annotations

import numpy as np
from scipy import ndimage

from ovman.agents.cow.settings import Cow
from ovman.agents.cow.voxel_map import EIGHT, Cell, VoxelMap, VoxelState


def frontier_targets(known: VoxelMap, agent: Cell, constants: Cow) -> list[Cell]:
    """One target cell for each cluster of frontier cells, the nearest to the agent first.

    Frontier cells without a free cell among their eight neighbours do not count; fewer than `frontier_cells` in total give no
    target. Single-linkage clusters at a distance below `cluster_voxels` = 1.5 are the eight-connected components. The target is
    the member nearest to the mean of its cluster. Raises ValueError for `cluster_voxels` outside (1, 2].
    """
    state = known.state
    frontier = (state == VoxelState.FRONTIER) & ndimage.binary_dilation(state == VoxelState.FREE, EIGHT)
    if frontier.sum() < constants.frontier_cells:
        return []
    reach = 1.0 < constants.cluster_voxels <= 2.0
    if not reach:
        raise ValueError(f"cow.cluster_voxels is {constants.cluster_voxels}; write a number above 1 and at most 2")
    labels, count = ndimage.label(frontier, EIGHT if constants.cluster_voxels > np.sqrt(2.0) else None)
    cells = np.argwhere(frontier)
    label = labels[frontier]
    means: np.ndarray = np.stack([np.bincount(label, cells[:, axis], count + 1)[1:] for axis in (0, 1)], axis=1)
    means /= np.bincount(label, minlength=count + 1)[1:, None]
    off = np.hypot(*(cells - means[label - 1]).T)
    order = np.lexsort((off, label))
    first = order[np.unique(label[order], return_index=True)[1]]
    targets = cells[first] + known.origin
    distance = np.hypot(*(targets - np.array(agent)).T)
    return [(int(i), int(j)) for i, j in targets[np.argsort(distance, kind="stable")]]
