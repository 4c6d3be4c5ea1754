"""Stage `segments`: the segments of an episode's tours, and what both tours say of the place of each. Pure."""

from __future__ import annotations

import time
from collections.abc import Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ovman.agents.joint import segments as weighing
from ovman.evaluation.recorded_tours import load_visit
from ovman.perception.records import read_detections
from ovman.processes import map_items
from ovman.records.episode import Episode
from ovman.records.visit import tour_path
from ovman.settings import Settings


def run(
    settings: Settings, episode_files: Sequence[Path], detections: Path, visits: Path, output: Path, workers: int = 1
) -> None:
    """Write the segments of both tours of every episode, one file per scene."""
    scenes = sorted({episode.scene for file in episode_files for episode in Episode.load(file)})
    output.mkdir(parents=True, exist_ok=True)
    map_items(partial(write_segments, settings, tuple(episode_files), detections, visits, output), scenes, workers)


def write_segments(
    settings: Settings, episode_files: Sequence[Path], detections: Path, visits: Path, output: Path, scene: str
) -> None:
    """Write the segments of a scene's episodes, and print how long an episode took."""
    episodes = [episode for file in episode_files for episode in Episode.load(file, scene)]
    pairs = {(one.visits.first, one.visits.second): one.protocol.camera.field_of_view_deg for one in episodes}
    seen = read_detections(detections / f"{scene}.npz")
    began = time.process_time()
    segments: dict[weighing.Tours, tuple[weighing.Segments, weighing.Segments]] = {}
    for pair, lens in pairs.items():
        first, second = (load_visit(tour_path(visits / scene, name), lens, np.zeros((0, 2))) for name in pair)
        tours = str(first.content), str(second.content)
        segments[tours] = weighing.weigh_tours(first, second, seen[pair[0]], seen[pair[1]], settings.joint)
    weighing.write_segments(output / f"{scene}.npz", segments)
    took = (time.process_time() - began) / max(len(pairs), 1)
    print(f"{scene}: segments of {len(pairs)} pairs of tours, {took:.2f} s of the processor each", flush=True)
