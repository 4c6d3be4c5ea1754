"""Stage `walks`: DualMap's observations on the dense tours of a scene's visits.

Frames of equal content are processed once per scene, because most frames of a second visit equal those of the first. The new
frames of a dense tour are saved when it ends, so that a killed job continues with the next one.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache as remember
from functools import partial
from itertools import compress
from pathlib import Path
from typing import Any

import numpy as np

from ovman import seeds
from ovman.agents.dualmap import DualmapObservation
from ovman.agents.dualmap.observations import NO_VIEW, Shot, pack_shots, unpack_shots, write_walks
from ovman.agents.dualmap.observing import Observer
from ovman.cache import Cache, digest
from ovman.perception import networks
from ovman.perception.array_file import ArrayFileError, read_arrays, write_arrays
from ovman.perception.labels import NOTHING, Labels, categories_of, shown, write_labels
from ovman.processes import Units, map_items
from ovman.records.episode import Episode, root_seed
from ovman.records.scene import Scene
from ovman.records.visit import Visit, tour_path
from ovman.settings import Settings
from ovman.settings.networks import Perception
from ovman.sim import walk
from ovman.sim.embodiment import Embodiment
from ovman.sim.images import colour_numbers
from ovman.sim.session import AgentPose, Session
from ovman.sim.walk import Frame
from ovman.sim.world import World

PART = "ovman-walk-part/3"
TOGETHER = 8
"""Batch size of frames."""


@dataclass(frozen=True, slots=True)
class Assigned:
    """A visit to walk through: its record, and the episode whose seed and id the mover's draws come from."""

    recorded: Visit
    episode: Episode

    @property
    def identity(self) -> list[Any]:
        """Everything that the frames of its dense tour depend on, JSON-serialisable."""
        episode, record = self.episode, self.recorded.to_json()
        protocol = {name: dict(getattr(episode.protocol, name)) for name in ("camera", "primitives", "mover")}
        drawn = [episode.backend, episode.provenance.seed, episode.id, protocol]
        return [*drawn, *(record[key] for key in ("alterations", "movers", "views"))]


def assign_visits(episodes: Sequence[Episode], visits: Path) -> dict[str, Assigned]:
    """Return the recorded visits of a scene's episodes by their names, sorted. visits: the scene's folder of recorded visits."""
    found: dict[str, Episode] = {}
    for episode in episodes:
        for which in (episode.visits.first, episode.visits.second):
            found.setdefault(which, episode)
    return {which: Assigned(Visit.load(tour_path(visits, which)), found[which]) for which in sorted(found)}


def embodiment(settings: Settings, side_px: int, instances: bool = False) -> Embodiment:
    """Return the benchmark's body with frames of side_px by side_px. instances: whether they come with masks."""
    return replace(Embodiment.of(settings), width_px=side_px, height_px=side_px, instances=instances)


def walk_frames(session: Session, of: Assigned, turn_deg: float) -> Iterable[Frame]:
    """Yield the frames of a visit's dense tour, in the world state that the visit was recorded in.

    Raises WalkError if the dense tour does not end as the visit did. turn_deg: between two frames of a spin.
    """
    settings = of.episode.settings
    rng = seeds.generator(settings.benchmark.seed, *seeds.tour_movers(of.episode.id))
    world = World(session, of.recorded.alterations, settings.mover, rng, object_filter=lambda _: False)
    views = [AgentPose(**dict(view.pose)) for view in of.recorded.views]
    lens = settings.camera.field_of_view_deg
    yield from walk.frames(session, world, views, turn_deg, settings.primitives.step_m, lens)
    walk.check(session, world, of.recorded)


def digest_frame(frame: Frame) -> str:
    """Return a digest of the picture, the depth and the camera of a frame."""
    found = hashlib.blake2b(repr(frame.camera).encode(), digest_size=16)
    for array in (frame.rgb, frame.depth):
        found.update(np.ascontiguousarray(array).data)
    return found.hexdigest()


Truth = list[tuple[str, int]]
"""Id of the instance that the mask of each object of a shot shows, "" for none, and the mask's pixels."""


def label_masks(masks: Sequence[np.ndarray], frame: Frame) -> Truth:
    """Return what the masks (H, W) of objects truly show in their frame."""
    if not masks:
        return []
    numbers, colours = colour_numbers(frame.masks)
    names = {number: name for name, number in colours.items()}
    found = shown(np.stack(masks), numbers).tolist()
    return [(names.get(number, ""), int(np.count_nonzero(mask))) for number, mask in zip(found, masks, strict=True)]


class Memory:
    """The shots of a scene by the content of their frames, and separately what they truly show, which no map uses."""

    def __init__(self, observer: Callable[[], Observer], runs: int, seed: int) -> None:
        self.shots: dict[str, Shot] = {}
        self.truths: dict[str, Truth] = {}
        self._observer, self._runs, self._seed = observer, runs, seed

    def process(self, frames: Iterable[Frame]) -> tuple[list[str], list[int], dict[str, tuple[Shot, Truth]]]:
        """Process the new frames of a dense tour. Returns content and view of every frame, and what the new frames show."""
        contents, views = [], []
        waiting: dict[str, Frame] = {}
        new: dict[str, tuple[Shot, Truth]] = {}
        for frame in frames:
            key = digest_frame(frame)
            contents.append(key)
            views.append(NO_VIEW if frame.view is None else frame.view)
            if key not in self.shots and key not in new and key not in waiting:
                waiting[key] = frame
                if len(waiting) == TOGETHER:
                    new |= self._look(waiting)
                    waiting = {}
        return contents, views, new | self._look(waiting)

    def _look(self, waiting: Mapping[str, Frame]) -> dict[str, tuple[Shot, Truth]]:
        """Process frames. The pixels that a run draws depend on the frame only, so that dense tours are independent."""
        if not waiting:
            return {}
        draws = [
            [seeds.generator(self._seed, "dualmap", "pixels", int(key, 16) % 2**32, run) for run in range(self._runs)]
            for key in waiting
        ]
        seen = self._observer().look(list(waiting.values()), draws)
        return {key: (shot, label_masks(masks, waiting[key])) for key, (shot, masks) in zip(waiting, seen, strict=True)}


def run(
    scene_files: Sequence[Path],
    episodes_file: Path,
    visits: Path,
    settings: Settings,
    cache: Cache,
    output: Path,
    labels_output: Path,
    workers: int = 1,
) -> None:
    """Write DualMap's observations on the dense tours of episodes, and what they truly show, one file per scene.

    visits: folder of the recorded tours, {scene}/{visit}; settings: section `perception`, and runs, walk and observation of
    section `dualmap`; cache: keeps finished dense tours; workers: number of processes over the scenes. Raises WalkError if a
    dense tour does not end as the recorded tour did.
    """
    wanted = {episode.scene for episode in Episode.load(episodes_file)}
    scenes = [scene.to_line() for file in scene_files for scene in Scene.read(file) if scene.scene in wanted]
    for folder in (output, labels_output):
        folder.mkdir(parents=True, exist_ok=True)
    map_items(partial(_walk_scene, episodes_file, visits, settings, cache, output, labels_output), scenes, workers)


def _walk_scene(
    episodes_file: Path, visits: Path, settings: Settings, cache: Cache, output: Path, labels_output: Path, scene: str
) -> None:
    """Write the observations of one scene, whose record is the line `scene`."""
    record = Scene.parse(scene)
    episodes = Episode.load(episodes_file, record.scene)
    of = assign_visits(episodes, visits / record.scene)
    perception, dualmap, protocol = settings.perception, settings.dualmap, next(iter(of.values())).episode.settings
    observer = remember(lambda: _observer(perception, dualmap.observation))
    memory = Memory(observer, dualmap.runs, root_seed(episodes))
    seen_by = networks.looked_at_by(perception)
    walks: dict[str, tuple[list[str], list[int]]] = {}
    units = Units(len(of))
    with Session(record.scene, protocol, embodiment(protocol, dualmap.walk.side_px, True)) as session:
        for name, one in of.items():
            began, before = time.process_time(), len(memory.shots)
            part = cache.path(digest(settings.constants(), seen_by, one.identity), ".npz")
            walks[name] = _read(part, memory) or session.with_restarts(
                partial(_walk, session, one, dualmap.walk.turn_deg, memory, cache, part)
            )
            took, new = time.process_time() - began, len(memory.shots) - before
            units.done(f"{name}: {len(walks[name][0])} frames, {new} of them new, {took:.1f} s of the processor")
    order = list(dict.fromkeys(key for contents, _ in walks.values() for key in contents))
    shots = [memory.shots[key] for key in order]
    ceiling_m = float(np.median([shot.top_m for shot in shots])) if shots else 0.0
    # Objects whose middle is near the height of the ceiling are part of it.
    low = [[bool(abs(one.middle_m - ceiling_m) >= dualmap.observation.ceiling_m) for one in shot.seen] for shot in shots]
    truths = {key: [*compress(memory.truths[key], mine)] for key, mine in zip(order, low, strict=True)}
    number = {key: k for k, key in enumerate(order)}
    write_walks(
        output / f"{record.scene}.npz",
        {name: ([number[key] for key in contents], views) for name, (contents, views) in walks.items()},
        [Shot(tuple(compress(shot.seen, mine)), shot.top_m) for shot, mine in zip(shots, low, strict=True)],
        observer().classes,
    )
    labels = {name: _labels([one for key in contents for one in truths[key]], record) for name, (contents, _) in walks.items()}
    write_labels(labels_output / f"{record.scene}.npz", labels)


def _walk(
    session: Session, one: Assigned, turn_deg: float, memory: Memory, cache: Cache, part: Path
) -> tuple[list[str], list[int]]:
    """Walk and save the new shots. Memory then holds the shots as read from the file, as after a restart."""
    contents, views, new = memory.process(walk_frames(session, one, turn_deg))
    truths = [shows for _, truth in new.values() for shows in truth]
    arrays = {"content": np.array(contents), "view": np.array(views, np.int16), "new": np.array(list(new), str)}
    arrays |= {"shows": np.array([name for name, _ in truths], str), "pixels": np.array([size for _, size in truths], np.int32)}
    arrays |= pack_shots([shot for shot, _ in new.values()])
    cache.write(part, lambda place: write_arrays(place, PART, arrays, compressed=True))
    kept = _read(part, memory)
    assert kept is not None
    return kept


def _read(part: Path, memory: Memory) -> tuple[list[str], list[int]] | None:
    """A saved walk, its shots added to memory; None if the file or a walk that it builds on is missing."""
    try:
        arrays = read_arrays(part, PART)
    except (FileNotFoundError, ArrayFileError):
        return None
    contents = arrays["content"].tolist()
    shots = dict(zip(arrays["new"].tolist(), unpack_shots(arrays), strict=True))
    if not {*contents} <= {*memory.shots, *shots}:
        return None
    memory.shots |= shots
    truths = iter(zip(arrays["shows"].tolist(), arrays["pixels"].tolist(), strict=True))
    memory.truths |= {key: [next(truths) for _ in shot.seen] for key, shot in shots.items()}
    return contents, arrays["view"].tolist()


def _labels(truth: Truth, scene: Scene) -> Labels:
    """Return the labels of the observations of a dense tour."""
    categories = categories_of(scene)
    names = tuple(sorted({*categories.values()}))
    shows = [categories.get(instance) for instance, _ in truth]
    category = np.array([NOTHING if name is None else names.index(name) for name in shows], np.int64)
    return Labels(names, category, np.array([pixels for _, pixels in truth], np.int64))


def _observer(perception: Perception, observation: DualmapObservation) -> Observer:
    return Observer(networks.detector_of(perception, observation.confidence), networks.encoder_of(perception), observation)
