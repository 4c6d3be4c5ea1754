"""Limits on the size of images: an event that exceeds the memory would end the engine."""

from __future__ import annotations

MAX_SIDE_PX = 8192
MAX_IMAGE_PX = 1 << 23
"""Pixels of one image: 4096 x 2048. 3840 x 2160 is within it and takes 1.2 GB with every kind of image."""
MAX_EVENT_PX = 1 << 25
"""Pixels of all cameras of an event together: a message of 570 MB with every kind of image."""


def objection(width: int, height: int, pictures: int = 1) -> str:
    """Why an event cannot have this many images of `width` x `height` pixels; empty if it can."""
    if not (0 < width <= MAX_SIDE_PX and 0 < height <= MAX_SIDE_PX and width * height <= MAX_IMAGE_PX):
        limits = f"1x1 and {MAX_IMAGE_PX} pixels, {MAX_SIDE_PX} on a side"
        return f"Screen resolution must be within {limits}, not {width}x{height}."
    if width * height * pictures > MAX_EVENT_PX:
        return f"{pictures} pictures of {width}x{height} are more than the {MAX_EVENT_PX} pixels that an event may have."
    return ""
