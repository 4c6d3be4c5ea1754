"""Detect the instances in tours: masks, their positions in the world, and embeddings of their crops."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache as remember
from functools import partial
from pathlib import Path

import numpy as np

from ovman.cache import Cache
from ovman.perception import networks, tour_files
from ovman.perception.array_file import ArrayFileError
from ovman.perception.backprojection import median_points
from ovman.perception.detector import Detector
from ovman.perception.encoder import Encoder, crop
from ovman.perception.records import Detected, keep_masks, read_detections, write_detections
from ovman.perception.tour_files import View
from ovman.processes import Units, map_items
from ovman.settings import Settings

Networks = Callable[[], tuple[Detector, Encoder]]
"""Return the networks, loaded at the first call."""
Tours = Mapping[str, Mapping[str, Path]]
"""Folders of recorded tours, by scene and by visit."""


def run(tours: Tours, settings: Settings, cache: Cache, output: Path, workers: int = 1) -> None:
    """Write the detections of tours, one file per scene in the folder `output`, which is called after its scene.

    Settings: perception.*, camera.field_of_view_deg. The cache keeps the detections of a tour by its content. WeightsError and
    TourError for files of networks and of tours that are missing or damaged.
    """
    output.mkdir(parents=True, exist_ok=True)
    map_items(partial(_write_scene, settings=settings, cache=cache, output=output), list(tours.items()), workers)


def _write_scene(tours: tuple[str, Mapping[str, Path]], settings: Settings, cache: Cache, output: Path) -> None:
    scene, visits = tours
    write_detections(output / f"{scene}.npz", detect_tours(visits, settings, cache, load_networks(settings)))


def load_networks(settings: Settings) -> Networks:
    """Return a function that loads the networks of section `perception` at its first call."""
    perception = settings.perception
    return remember(lambda: (networks.detector_of(perception), networks.encoder_of(perception)))


def detect_tours(visits: Mapping[str, Path], settings: Settings, cache: Cache, load: Networks) -> dict[str, Detected]:
    """Return the detections of tours by their names, in their order. Raises as `run`.

    The networks are loaded at the first tour that the cache lacks.
    """
    perception, field_of_view_deg = settings.perception, settings.camera.field_of_view_deg
    seen_by = json.dumps(networks.looked_at_by(perception), sort_keys=True)
    found: dict[str, Detected] = {}
    units = Units(len(visits))
    for name, directory in visits.items():
        began, content = time.process_time(), tour_files.digest(directory, field_of_view_deg, seen_by)
        path = cache.path(content, ".npz")
        is_cached = _is_whole(path, content)
        if not is_cached:
            views = list(tour_files.tour(directory, field_of_view_deg))
            sizes = perception.detector.min_mask_px, perception.encoder.crop_padding
            detected = detect_views(views, *load(), *sizes, content)
            cache.write(path, partial(write_detections, visits={content: detected}))
        found[name] = read_detections(path)[content]
        took = "seen before" if is_cached else f"{time.process_time() - began:.1f} s of the processor"
        units.done(f"{name}: {len(found[name])} detections, {took}")
    return found


def detect_views(
    views: Sequence[View], detector: Detector, encoder: Encoder, min_mask_px: int, crop_padding: float, content: str = ""
) -> Detected:
    """Return the detections in the views of a tour (at least one), in their order.

    A mask counts if it has at least `min_mask_px` pixels and some of them have depth; its position is the median of those
    (Eq. backproj). Raises ValueError for a tour without views.
    """
    if not views:
        raise ValueError("a tour without views shows nothing")
    masks, points, crops, confidence, numbers = [], [], [], [], []
    for number, (view, seen) in enumerate(zip(views, detector.detect([view.rgb for view in views]), strict=True)):
        large = seen.masks.sum(axis=(1, 2), dtype=np.int64) >= min_mask_px
        found, sure = seen.masks[large], seen.confidence[large]
        places = median_points(view.depth, found, view.camera)
        placed = ~np.isnan(places[:, 0])
        found, sure = found[placed], sure[placed]
        masks.append(found)
        points.append(places[placed])
        confidence.append(sure)
        numbers.append(np.full(len(found), number, np.int64))
        crops += [crop(view.rgb, mask, crop_padding, encoder.side_px, encoder.contrast) for mask in found]
    every = np.concatenate(masks)
    squares = np.stack(crops) if crops else np.zeros((0, encoder.side_px, encoder.side_px, 3), np.uint8)
    return Detected(
        view=np.concatenate(numbers),
        point=np.concatenate(points),
        feature=encoder.images(squares),
        pixels=every.sum(axis=(1, 2), dtype=np.int64),
        confidence=np.concatenate(confidence).astype(np.float32),
        masks=keep_masks(every),
        content=content,
    )


def _is_whole(path: Path, content: str) -> bool:
    """Return whether a file of the cache has the detections of a content, all arrays verified."""
    try:
        read_detections(path)[content].masks()  # masks are read when they are asked for, and verified then
    except (FileNotFoundError, KeyError):
        return False
    except ArrayFileError as error:
        print(f"{error}; its tour is looked at again", flush=True)
        return False
    return True
