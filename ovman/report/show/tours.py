"""Show the frames of a tour as small pictures with outlines of detections, filled grounded objects, and true masks on top."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from ovman.perception import tour_files
from ovman.perception.records import Detected
from ovman.records.episode import Episode
from ovman.records.visit import Visit
from ovman.report.show.reasoning import Item, Reasoning

QUALITY = 78
"""Quality of the JPEG files."""
SIDE_PX = 240
"""Largest height of the embedded pictures; the masks keep the coordinates of the frames."""
STRAY_PX = 1.2
"""Largest distance between an outline and its mask."""
SAME_PLACE_M = 1e-3


@dataclass(frozen=True, slots=True)
class Outline:
    """An SVG path `d` in the frame's pixels. kind: its CSS classes; title: its tooltip."""

    d: str
    kind: str
    title: str


@dataclass(frozen=True, slots=True)
class TourFrame:
    """A view of a tour. picture: a data URI; target_px: size of the target's true mask, 0 if it is not seen."""

    view: int
    yaw_deg: float
    picture: str
    width: int
    height: int
    outlines: tuple[Outline, ...]
    truths: tuple[Outline, ...]
    target_px: int


@dataclass(frozen=True, slots=True)
class Stand:
    """A waypoint and its frames. number: counts from 1; at: (x, z) in metres."""

    number: int
    at: tuple[float, float]
    frames: tuple[TourFrame, ...]


def show_tour(
    visit: Visit, directory: Path, episode: Episode, detected: Detected | None, reasonings: Sequence[Reasoning], which: int
) -> list[Stand]:
    """Return the frames of a recorded tour by waypoint. detected: None without detections; which: 0 or 1, the visit."""
    named = [[(k, item, reasoning) for item in reasoning.items[which]] for k, reasoning in enumerate(reasonings)]
    own = [entry for row in named for entry in row if entry[2].own_maps]
    masks = np.zeros((0, 0, 0), bool) if detected is None else detected.masks()
    found: list[tuple[tuple[float, float], list[TourFrame]]] = []
    for index, view in enumerate(visit.views):
        outlines = [] if detected is None else _outline_detections(detected, masks, index, own)
        frame = _show_frame(visit, directory, index, episode, outlines)
        at = (view.pose.x, view.pose.z)
        if not found or found[-1][0] != at:
            found.append((at, []))
        found[-1][1].append(frame)
    return [Stand(number, at, tuple(frames)) for number, (at, frames) in enumerate(found, start=1)]


def trace_outline(mask: np.ndarray) -> str:
    """Return the SVG path around a mask (H, W) bool, in pixels; empty for an empty mask."""
    contours, _ = cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    parts = []
    for contour in contours:
        points = cv2.approxPolyDP(contour, STRAY_PX, closed=True)[:, 0]
        if len(points) > 2:
            parts.append("M" + "L".join(f"{u} {v}" for u, v in points.tolist()) + "Z")
    return "".join(parts)


def embed_picture(path: Path) -> tuple[str, int, int]:
    """Return a PNG file as a data URI of a JPEG at most SIDE_PX high, with the PNG's width and height.

    Raises:
        TourError: The file is missing or damaged.
    """
    image = tour_files.picture(path)
    height, width = image.shape[:2]
    scale = min(1.0, SIDE_PX / height)
    small = cv2.resize(image, (round(width * scale), round(height * scale)), interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, QUALITY])
    return "data:image/jpeg;base64," + base64.b64encode(data.tobytes()).decode("ascii"), width, height


def _show_frame(visit: Visit, directory: Path, index: int, episode: Episode, outlines: list[Outline]) -> TourFrame:
    view = visit.views[index]
    uri, width, height = embed_picture(directory / f"{index:02d}_rgb.png")
    ids = tour_files.picture(directory / f"{index:02d}_ids.png")
    truths = []
    for number, name in enumerate(view.instances, start=1):
        kind = "target" if name == episode.target else "distractor" if name == episode.distractor else "instance"
        if name in view.seen and name in visit.present and visit.present[name].category == episode.category:
            mask: np.ndarray = ids == number
            truths.append(Outline(trace_outline(mask), f"true {kind}", f"{name}: {view.seen[name]} px (truth)"))
    return TourFrame(
        view=index,
        yaw_deg=view.pose.yaw_deg,
        picture=uri,
        width=width,
        height=height,
        outlines=tuple(outlines),
        truths=tuple(truths),
        target_px=view.seen.get(episode.target, 0),
    )


def _outline_detections(
    detected: Detected, masks: np.ndarray, index: int, items: Sequence[tuple[int, Item, Reasoning]]
) -> list[Outline]:
    """Return the outlines of a view's detections, each with its map object and the arms that ground that object."""
    outlines = []
    for n in np.flatnonzero(detected.view == index).tolist():
        place = (float(detected.point[n][0]), float(detected.point[n][2]))
        members = [(k, item) for k, item, _ in items if _contains(item, index, place)]
        classes = ["mask", *(f"grounded-{k}" for k, item in members if item.grounded)]
        title = f"detected with confidence {float(detected.confidence[n]):.2f}"
        if members:
            item = members[0][1]
            score = "" if item.similarity is None else f", similarity {item.similarity:.3f}"
            title = f"object {item.id}{score}; {title}"
        outlines.append(Outline(trace_outline(masks[n]), " ".join(classes), title))
    return outlines


def _contains(item: Item, view: int, place: tuple[float, float]) -> bool:
    """Return whether an object of the map contains the detection at `place` in `view`."""
    return any(
        seen == view and abs(x - place[0]) < SAME_PLACE_M and abs(z - place[1]) < SAME_PLACE_M
        for seen, (x, z) in zip(item.views, item.track, strict=True)
    )
