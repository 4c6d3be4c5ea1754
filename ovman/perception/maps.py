"""Cluster the detections of recorded tours into maps: one per visit, or one of both visits of an episode."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from pathlib import Path

from ovman.cache import Cache
from ovman.perception.clusters import Cluster, Detection, clusters
from ovman.perception.detections import Tours, detect_tours, load_networks
from ovman.perception.records import Detected, name_pair, read_detections, write_maps
from ovman.processes import map_items
from ovman.records.episode import Episode
from ovman.settings import Settings


def build_map(tours: Sequence[Detected], radius_m: float) -> tuple[Cluster, ...]:
    """Return the map of one tour, or of several one after the other: (p, f, T) of every cluster of their detections.

    Views and detections are numbered through all tours. radius_m: Cluster radius on the floor plane, metres.
    """
    detections: list[Detection] = []
    views = 0
    for seen in tours:
        rows = zip((seen.view + views).tolist(), seen.point, seen.feature, strict=True)
        detections += [Detection(view, point, feature) for view, point, feature in rows]
        views = detections[-1].view + 1 if detections else 0
    return clusters(detections, radius_m)


def run(detections: Path, settings: Settings, output: Path) -> None:
    """Write the maps of all visits, one file per scene in the folder `output`, from the files in the folder `detections`."""
    output.mkdir(parents=True, exist_ok=True)
    for source in sorted(detections.glob("*.npz")):
        found = {name: build_map([seen], settings.maps.cluster_radius_m) for name, seen in read_detections(source).items()}
        _write(output / source.name, found)


def run_both_visits(episodes_file: Path, detections: Path, settings: Settings, output: Path) -> None:
    """Write the one map of both visits of every episode, as an agent keeps that does not tell visits apart.

    The detections of the second tour go on where those of the first ended: an object that stays where it is joins its cluster,
    one that is somewhere else begins a new cluster, and nothing is taken back.
    """
    output.mkdir(parents=True, exist_ok=True)
    episodes = Episode.load(episodes_file)
    for source in sorted(detections.glob("*.npz")):
        seen = read_detections(source)
        pairs = dict.fromkeys((e.visits.first, e.visits.second) for e in episodes if e.scene == source.stem)
        radius_m = settings.maps.cluster_radius_m
        _write(output / source.name, {name_pair(*pair): build_map([seen[name] for name in pair], radius_m) for pair in pairs})


def run_tours(tours: Tours, settings: Settings, cache: Cache, output: Path, workers: int = 1) -> None:
    """Write the maps of tours, one file per scene in the folder `output`; for the rest see `ovman.perception.detections.run`."""
    output.mkdir(parents=True, exist_ok=True)
    map_items(partial(_write_scene, settings=settings, cache=cache, output=output), list(tours.items()), workers)


def _write_scene(tours: tuple[str, dict[str, Path]], settings: Settings, cache: Cache, output: Path) -> None:
    scene, visits = tours
    seen = detect_tours(visits, settings, cache, load_networks(settings))
    _write(output / f"{scene}.npz", {name: build_map((one,), settings.maps.cluster_radius_m) for name, one in seen.items()})


def _write(path: Path, maps: dict[str, tuple[Cluster, ...]]) -> None:
    write_maps(path, maps)
    average = sum(map(len, maps.values())) / max(len(maps), 1)
    print(f"{path.stem}: {len(maps)} maps, {average:.0f} clusters on average", flush=True)
