"""Measure the cost of mapping per episode on one core.

    python bench/perception.py [--config config.yaml] [--scenes FloorPlan201 ...] [--repeats 3]

Tours of some floor plans are recorded with the engine and mapped with the networks of the configuration. Episodes share tours,
and each tour is mapped once, so the cost per episode is that of the distinct tours per released episode. Kinds of measurement
alternate; times are processor times. Ratios compare the whole with the bare passes through both networks, on as many pictures
and crops. The last table compares the numbers with their bounds.
"""

from __future__ import annotations

import argparse
import os
import resource
import subprocess
import sys
import tempfile
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from measure.bars import Bar, show
from measure.clock import processor, taken
from ovman import seeds
from ovman.perception import networks, tour_files
from ovman.perception.backprojection import median_points
from ovman.perception.detections import detect_views
from ovman.perception.encoder import TOGETHER, crop
from ovman.perception.maps import build_map
from ovman.perception.records import write_detections, write_maps
from ovman.perception.weights import WeightsError
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.records.tour import Tour
from ovman.settings.config import load
from ovman.shipped import HOME as ROOT
from ovman.sim import visit
from ovman.sim.session import Session
from ovman.sim.world import World

SCENES = ("FloorPlan201", "FloorPlan1", "FloorPlan429")
RELEASE = ROOT / "data" / "ovman-embedded-v6"
EPISODE_S, BARE, START_S = 1.9, 1.75, 1.0
"""Bounds: seconds of one core per episode, the paper's number on a GPU; the whole over the bare passes of the networks; processor
seconds from the start of a process to its first detections and embeddings."""
START = """
import sys
from pathlib import Path
import numpy as np
from ovman.perception.networks import detector_of, encoder_of
from ovman.settings.config import load
perception = load(Path(sys.argv[1])).perception
detector, encoder = detector_of(perception), encoder_of(perception)
detector.detect([np.zeros((300, 300, 3), np.uint8)])
encoder.images(np.zeros((1, encoder.side_px, encoder.side_px, 3), np.uint8))
"""


def distinct_tours() -> tuple[int, int]:
    """Return the numbers of distinct tours and of episodes of the release."""
    episodes = Episode.load(RELEASE / "episodes" / "main.jsonl")
    return len({(e.scene, name) for e in episodes for name in (e.visits.first, e.visits.second)}), len(episodes)


def first_frame_s(config: Path) -> float:
    """Return the processor seconds of a process that looks at one frame, with caches filled by an earlier process."""

    def used() -> float:
        spent = resource.getrusage(resource.RUSAGE_CHILDREN)
        return spent.ru_utime + spent.ru_stime

    for _ in range(2):
        before = used()
        subprocess.run([sys.executable, "-c", START, str(config)], check=True)
    return used() - before


def record(scene: str, settings: Any, directory: Path) -> Path:
    """Record the tour of an untouched floor plan along the released waypoints."""
    survey = next(one for one in Scene.read(RELEASE / "scenes" / "main.jsonl") if one.scene == scene)
    views = visit.views(Tour(waypoints=survey.waypoints, headings=settings.tour.headings))
    with Session(scene, settings) as session:
        world = World(session, [], settings.mover, seeds.generator(0, "bench"))
        visit.record(session, world, scene, [], views, settings.measurement.min_mask_px, directory / scene, "")
    return directory / scene


def kinds(directory: Path, settings: Any, detector: Any, encoder: Any) -> tuple[dict[str, Callable[[], object]], int]:
    """Return the mapping of a tour as callables, whole and in parts, and its number of detections."""
    perception, field_of_view_deg = settings.perception, settings.camera.field_of_view_deg
    limits = perception.detector.min_mask_px, perception.encoder.crop_padding
    views = list(tour_files.tour(directory, field_of_view_deg))
    pictures = [view.rgb for view in views]
    seen = detect_views(views, detector, encoder, *limits)
    masks = [seen.masks()[seen.view == number] for number in range(len(views))]
    shown = [(view, mask) for view, found in zip(views, masks, strict=True) for mask in found]
    cut = perception.encoder.crop_padding, encoder.side_px, encoder.contrast
    crops = np.stack([crop(view.rgb, mask, *cut) for view, mask in shown])
    rng = np.random.default_rng(0)
    frames = rng.random((len(views), 1, 3, *[perception.detector.side_px] * 2), np.float32)
    squares = rng.random((len(crops), 3, encoder.side_px, encoder.side_px), np.float32)

    def whole() -> None:
        found = detect_views(list(tour_files.tour(directory, field_of_view_deg)), detector, encoder, *limits)
        write_detections(directory.with_name("detections.npz"), {"tour": found})
        write_maps(directory.with_name("maps.npz"), {"tour": build_map([found], settings.maps.cluster_radius_m)})

    def bare() -> None:
        for frame in frames:
            detector.network(frame)
        for start in range(0, len(squares), TOGETHER):
            encoder.tower(squares[start : start + TOGETHER])

    return {
        "the networks alone": bare,
        "tour to map": whole,
        "  digest of its frames": lambda: tour_files.digest(directory, field_of_view_deg, ""),
        "  frames and depth from files": lambda: list(tour_files.tour(directory, field_of_view_deg)),
        "  masks": lambda: detector.detect(pictures),
        "  places": lambda: [median_points(view.depth, found, view.camera) for view, found in zip(views, masks, strict=True)],
        "  crops": lambda: [crop(view.rgb, mask, *cut) for view, mask in shown],
        "  embeddings": lambda: encoder.images(crops),
        "  clusters": lambda: build_map([seen], settings.maps.cluster_radius_m),
        "  files": lambda: write_detections(directory.with_name("detections.npz"), {"tour": seen}),
    }, len(seen)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--config", type=Path, default=ROOT / "config.yaml")
    parser.add_argument("--scenes", nargs="+", default=SCENES)
    parser.add_argument("--repeats", type=int, default=3)
    options = parser.parse_args()
    os.environ.setdefault("DISPLAY", ":0")
    os.environ.pop("CUDA_VISIBLE_DEVICES", None)
    if hasattr(os, "sched_setaffinity"):
        os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})
    settings = load(options.config)
    tours, episodes = distinct_tours()
    names = ("mapping an episode", "a tour, x its networks' bare passes", "a process to its first frame")
    try:
        detector, encoder = networks.detector_of(settings.perception), networks.encoder_of(settings.perception)
    except WeightsError as error:
        print(error)
        show(
            [
                Bar(name, None, bar, unit)
                for name, bar, unit in zip(names, (EPISODE_S, BARE, START_S), ("s", "x", "s"), strict=True)
            ]
        )
        return
    print(f"{processor()}, one core; {tours} distinct tours to {episodes} episodes")
    costs, ratios = [], []
    with tempfile.TemporaryDirectory() as directory:
        for scene in options.scenes:
            calls, count = kinds(record(scene, settings, Path(directory)), settings, detector, encoder)
            _, busy = taken(calls, options.repeats, {})
            print(f"\n{scene}, {count} detections{'ms a tour':>30s}{'x networks':>12s}")
            least = {name: values.min() for name, values in busy.items()}
            for name, seconds in least.items():
                print(f"{name:42s}{seconds * 1e3:12.1f}{seconds / least['the networks alone']:12.2f}", flush=True)
            costs.append(least["tour to map"])
            ratios.append(least["tour to map"] / least["the networks alone"])
    an_episode = float(np.mean(costs)) * tours / episodes
    print(f"\n{np.mean(costs):.2f} s a tour, {an_episode:.2f} s an episode, {an_episode * episodes:.0f} s for all {episodes}")
    started = first_frame_s(options.config)
    show(
        [
            Bar(names[0], an_episode, EPISODE_S, "s"),
            Bar(names[1], float(np.mean(ratios)), BARE, "x"),
            Bar(names[2], started, START_S, "s"),
        ]
    )


if __name__ == "__main__":
    main()
