"""Show the frames of a tour as small pictures with outlines of detections and of true masks."""

from __future__ import annotations

import base64
from collections.abc import Mapping, Sequence
from itertools import groupby
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ovman.perception import tour_files
from ovman.perception.records import Detected
from ovman.records.episode import Episode
from ovman.records.visit import Visit
from ovman.report.show.evidence import Item

QUALITY = 78
"""Quality of the JPEG files."""
SIDE_PX = 240
"""Largest height of the embedded pictures; the masks keep the coordinates of the frames."""
STRAY_PX = 1.2
"""Largest distance between an outline and its mask."""
Outline = tuple[str, str, str]
"""An outline's CSS classes, its SVG path in the frame's pixels, and its tooltip."""


def show_tour(tour: Path, detected: Detected, episode: Episode, items: Sequence[Item]) -> list[list[dict[str, Any]]]:
    """Return the frames of a recorded tour by waypoint. items: the objects of its map, if an arm's evidence has them."""
    visit, masks, of_detection = Visit.load(tour), detected.masks(), {n: item for item in items for n in item.members}
    frames = []
    for number, view in enumerate(visit.views):
        picture, width, height = embed_picture(tour, number)
        outlines = [
            _outline_detection(masks[n], float(detected.confidence[n]), of_detection.get(n))
            for n in np.flatnonzero(detected.view == number).tolist()
        ]
        frame = {
            "number": number,
            "at": (view.pose.x, view.pose.z),
            "yaw_deg": view.pose.yaw_deg,
            "picture": picture,
            "width": width,
            "height": height,
            "outlines": outlines,
            "truths": _outline_truths(tour, number, visit, episode),
            "target_px": view.seen.get(episode.target, 0),
        }
        frames.append(frame)
    return [list(of) for _, of in groupby(frames, key=lambda frame: frame["at"])]


def trace_outline(mask: np.ndarray) -> str:
    """Return the SVG path around a mask (H, W) bool, in pixels; empty for an empty mask."""
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    shapes = [cv2.approxPolyDP(contour, STRAY_PX, closed=True)[:, 0].tolist() for contour in contours]
    return "".join("M" + "L".join(f"{u} {v}" for u, v in points) + "Z" for points in shapes if len(points) > 2)


def embed_picture(tour: Path, number: int) -> tuple[str, int, int]:
    """Return the colours of a view as a data URI of a JPEG at most SIDE_PX high, with their own width and height.

    Raises:
        TourError: The picture is missing or damaged.
    """
    image = tour_files.picture(tour, number, "rgb")
    height, width = image.shape[:2]
    scale = min(1.0, SIDE_PX / height)
    small = cv2.resize(image, (round(width * scale), round(height * scale)), interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode("ascii"), width, height


def _outline_detection(mask: np.ndarray, confidence: float, item: Item | None) -> Outline:
    title = f"detected with confidence {confidence:.2f}"
    if item is None:
        return "mask", trace_outline(mask), title
    return f"mask {'grounded' * item.is_grounded}", trace_outline(mask), f"{item.title}; {title}"


def _outline_truths(tour: Path, number: int, visit: Visit, episode: Episode) -> list[Outline]:
    """Return the outlines of the true masks of the category's instances in a view."""
    view, ids = visit.views[number], tour_files.picture(tour, number, "ids")
    roles: Mapping[str | None, str] = {episode.target: "true target", episode.distractor: "true distractor"}
    return [
        (roles.get(name, "true"), trace_outline(ids == value), f"{name}: {view.seen[name]} px (truth)")
        for value, name in enumerate(view.instances, start=1)
        if name in view.seen and name in visit.present and visit.present[name].category == episode.category
    ]
