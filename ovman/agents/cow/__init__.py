"""CoW, reimplemented: frontier-based exploration that stops at the first detection of the category.

Written from the published description of "CoWs on Pasture" (Gadre et al., CVPR 2023) and its constants. It knows one visit, takes
RGB, depth and the noun of the category, and dead-reckons where it is from the actions that it commands.

Frame: the camera's at the start of the episode, metres; x to the right, y up, z ahead, yaw in degrees clockwise seen from above.
Cells are voxels of the floor plane, (i, j) of x and z.
"""
