"""CoW, reimplemented: frontier-based exploration that stops at the first detection of the category.

Written from the published description of "CoWs on Pasture" (Gadre et al., CVPR 2023) and its constants. It knows one visit, takes
RGB, depth and the noun of the category, and dead-reckons where it is from the actions that it commands.

Frame: the camera's at the start of the episode, metres; x to the right, y up, z ahead, yaw in degrees clockwise seen from above.
Cells are voxels of the floor plane, (i, j) of x and z.
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from ovman.section import Metres, Probability, Section, Some, Voxels


class Locobot(Section):
    """CoW's body: AI2-THOR's agentMode "locobot", whose moves and turns err. Steps and turns are the benchmark's."""

    # Released: 672, resized to 224 before anything looks at it.
    side_px: Some = Field(224, description="of its square frames")
    field_of_view_deg: Annotated[float, Field(gt=0, lt=180)] = Field(90.0, description="vertical and horizontal")


class Cow(Section):
    """CoW (Gadre et al., CVPR 2023). Lengths are metres unless the name says voxels.

    Values are those of the released code except `similarity`.
    """

    # The cosine to "a photo of a {noun}"; OWL-ViT's 0.125 is on another scale. It has the best F1, 0.500, of a sweep by 0.0025 on
    # 100 views of each held-out floor plan (training/thresholds.py).
    similarity: Annotated[float, Field(ge=-1, le=1)] = Field(0.3025, description="cosine from which an instance is the category")
    # The published headline.
    centre_only: bool = Field(True, description="whether the centre of a box alone is relevant, or all of it")
    image_px: Some = Field(224, description="side of the depth and relevance images that are mapped")
    voxel_m: Metres = Field(0.125, description="side of a voxel")
    # That of AI2-THOR's LoCoBot.
    camera_height_m: Metres = Field(0.8658, description="of the camera above the floor")
    floor_tolerance_m: Metres = Field(0.05, description="up to which a point is at the height of the floor")
    ceiling_m: Metres = Field(1.9, description="height above which nothing is mapped, less camera height and tolerance")
    nearest_depth_m: Metres = Field(0.051, description="up to which a pixel has no depth")
    unchanged_depth_m: Metres = Field(
        0.09, description="mean and standard deviation of a change of depth below which an action has failed"
    )
    # (360 - 90) / 30.
    spin_turns: Some = Field(9, description="turns of a look around")
    ray_step_voxels: Voxels = Field(0.25, description="along rays over the floor")
    relevant: Probability = Field(0.9, description="relevance above which a voxel is of interest")
    frontier_cells: Some = Field(3, description="fewest cells that are a frontier")
    cluster_voxels: Annotated[float, Field(gt=1, le=2)] = Field(
        1.5, description="distance below which frontier cells belong to one cluster"
    )
    waypoint_voxels: Voxels = Field(3.5, description="distance up to which a waypoint is reached")
    visited_voxels: Some = Field(5, description="side of the square around a visited frontier that is visited with it")
    expansions: Some = Field(50, description="of the search for actions to a waypoint")
    # 1 m.
    stop_voxels: Voxels = Field(8.0, description="distance to a region of interest below which the agent stops")
