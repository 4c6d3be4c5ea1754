"""Stage `maintained`: one map of both tours of an episode, as an agent keeps that does not tell visits apart. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.perception.maps import mapped
from ovman.perception.records import read_detections, write_maps
from ovman.records.episode import Episode
from ovman.settings import Settings


def together(first: str, second: str) -> str:
    """The name under which a file has the one map of two visits."""
    return f"{first} and {second}"


def run(detections: Sequence[Path], episodes_files: Sequence[Path], constants: Settings, maps: Sequence[Path]) -> None:
    """Writes the one map of both visits of every episode, one file for each file of detections in their order.

    episodes_files: of the splits that have the scenes.

    The detections of the second tour go on where those of the first ended: what stays where it is joins its cluster, what is
    somewhere else begins one, and nothing is taken back.
    """
    episodes = [episode for file in episodes_files for episode in Episode.load(file)]
    for source, output in zip(detections, maps, strict=True):
        seen = read_detections(source)
        pairs = dict.fromkeys((e.visits.first, e.visits.second) for e in episodes if e.scene == source.stem)
        found = {together(*pair): mapped([seen[name] for name in pair], constants.maps.cluster_radius_m) for pair in pairs}
        write_maps(output, found)
        counts = [len(clusters) for clusters in found.values()]
        average = sum(counts) / max(len(counts), 1)
        print(f"{source.stem}: {len(found)} maps of two visits, {average:.0f} clusters on average", flush=True)
