"""Stage `maps`: clusters the detections of every tour into the map of its visit. Pure."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.perception.clusters import Cluster, Detection, clusters
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections, write_maps
from ovman.settings import Settings


def mapped(tours: Sequence[Detected], radius_m: float) -> tuple[Cluster, ...]:
    """The map of one tour, or of several one after the other: (p, f, T) of every cluster of their detections at `radius_m` metres
    on the floor plane. Views and detections are numbered through all tours.
    """
    detections: list[Detection] = []
    views = 0
    for seen in tours:
        rows = zip((seen.view + views).tolist(), seen.point, seen.feature, strict=True)
        detections += [Detection(view, point, feature) for view, point, feature in rows]
        views = detections[-1].view + 1 if detections else 0
    return clusters(detections, radius_m)


def run(detections: Sequence[Path], constants: Settings, maps: Sequence[Path]) -> None:
    """Writes the maps of all visits of each file of detections, one file for each in their order."""
    for source, output in zip(detections, maps, strict=True):
        found = {name: mapped([seen], constants.maps.cluster_radius_m) for name, seen in read_detections(source).items()}
        write_maps(output, found)
        counts = [len(clusters) for clusters in found.values()]
        print(f"{source.stem}: {len(found)} maps, {sum(counts) / max(len(counts), 1):.0f} clusters on average", flush=True)
