"""DynaMem, reimplemented: a memory of voxels that forgets what a later view sees through, and what it answers.

Written from the paper's abstract and the behaviour and constants of the released code (Liu et al., "DynaMem: Online Dynamic
Spatio-Semantic Memory for Open World Mobile Manipulation", 2024; hello-robot/stretch_ai, Apache-2.0).
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.section import Metres, Section, Some, Whole


class Dynamem(Section):
    """DynaMem's memory and its query. Lengths are metres, depths are along the optical axis.

    Values are those of the released code (hello-robot/stretch_ai at 8d52166) in the mode that asks features alone, except
    `every_px` and `similarity`.
    """

    # Of the memory of features. 0.1 is its map of obstacles, and its memory in the mode that asks a language model.
    voxel_m: Metres = Field(0.05, description="side of a voxel")
    nearest_m: Metres = Field(0.25, description="depth from which a pixel becomes a point")
    farthest_m: Metres = Field(2.5, description="depth up to which a pixel becomes a point, and up to which points are deleted")
    hidden_m: Metres = Field(0.1, description="a point with something nearer before it, by more than this, is hidden")
    unknown_m: Metres = Field(0.01, description="up to which a depth is not known")
    median_px: Annotated[Whole, Field(ge=1, le=99)] = Field(5, description="side of the median filter of depth, odd")
    median_error_m: Metres = Field(0.01, description="a pixel that differs by as much from its median becomes no point")
    # 10,000 pixels of 300 x 300. Released: 8,640 of 480 x 360, 5 % of them, drawn at random.
    every_px: Some = Field(3, description="rows and columns of a frame that become points")
    cluster_voxels: Annotated[float, Field(gt=0)] = Field(4.0, description="sides of a voxel within which points are neighbours")
    cluster_points: Some = Field(10, description="neighbours of one frame, itself included, without which a point is noise")
    # Released: 0.15 of OWLv2 and 0.21 of SigLIP, which are on other scales. Here a cosine to the noun. Its F1 is best at this
    # value and nearly the same within 0.02 of it (training/thresholds.py).
    similarity: Annotated[float, Field(ge=-1, le=1)] = Field(
        0.4025, description="cosine from which something is what the noun means"
    )
    detected_m: Metres = Field(3.0, description="nearest depth of a detection that confirms an answer is below this")
