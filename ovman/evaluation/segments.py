"""Stage `segments`: what each frame of an episode's tours shows, and what both tours say of its place. Pure."""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from ovman.agents.joint.recorded import Tours, write
from ovman.agents.joint.segments import Segments, evidence
from ovman.evaluation.recorded_tour import recorded
from ovman.perception.records import read_detections
from ovman.records.episode import Episode
from ovman.settings import Settings


def run(detections: Path, episodes_files: Sequence[Path], visits: Path, constants: Settings, output: Path) -> None:
    """Writes the segments of both tours of every episode of a scene, and prints how long an episode took.

    detections: of the scene, which the file is named after; episodes_files: of the splits that have it; visits: directory of all
    scenes' recorded visits.
    """
    episodes = [episode for file in episodes_files for episode in Episode.load(file, detections.stem)]
    pairs = {(e.visits.first, e.visits.second): e.protocol.camera.field_of_view_deg for e in episodes}
    seen = read_detections(detections)
    began = time.process_time()
    every: dict[Tours, tuple[Segments, Segments]] = {}
    for pair, lens in pairs.items():
        first, second = (recorded(visits / detections.stem / name, lens, np.zeros((0, 2))) for name in pair)
        contents = str(first.content), str(second.content)
        every[contents] = evidence(first, second, seen[pair[0]], seen[pair[1]], constants.joint)
    write(output, every)
    took = (time.process_time() - began) / max(len(pairs), 1)
    print(f"{detections.stem}: segments of {len(pairs)} pairs of tours, {took:.2f} s of the processor each", flush=True)
