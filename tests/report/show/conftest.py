"""A results directory with one small episode of each relation, made by the writers and stages that make the real one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from ovman.analysis.metrics import write_metrics
from ovman.evaluation import labels, predictions
from ovman.language import noun
from ovman.language.vocabulary import all_nouns
from ovman.perception import maps
from ovman.perception.detected import Detected, PackedMasks
from ovman.perception.records import write_detections, write_nouns
from ovman.records.episode import Episode, Protocol, Provenance
from ovman.records.geometry import Position, Spawn
from ovman.records.record import line, lines
from ovman.records.scene import Change, MoverStart, Roam, Scene, SceneObject
from ovman.records.task import Instance, WorldState
from ovman.records.tour import Tour
from ovman.records.trial import ReachableBox
from ovman.records.visit import Present, Sighting, Sightings, View, ViewPose, Visit, VisitPair, seal
from ovman.settings import Kind, Need, Settings, config, of_kind
from ovman.settings.jobs import arm_job, settings_of_arm
from ovman.task import Relation
from tests.arms import REFERENCE

ROOT = Path(__file__).resolve().parents[3]
SCENE, CATEGORY = "FloorPlan1", "Chair"
HEIGHT, WIDTH = 30, 40
WAYPOINTS = [(1.0, 1.0), (3.0, 2.0)]
TOUR = Tour(waypoints=tuple(WAYPOINTS), headings=2)
VIEWS = [(x, z, yaw) for x, z in WAYPOINTS for yaw in (0.0, 180.0)]
CHAIRS = {"Chair|a": (0.5, 3.0), "Chair|b": (2.5, 3.5), "Chair|c": (4.0, 0.5)}
LAMP = "FloorLamp|d"
ELSEWHERE = (3.5, 3.5)

World = dict[str, tuple[float, float]]


def _worlds(relation: Relation) -> tuple[World, World, str, str | None, tuple[Change, ...]]:
    """Both worlds, target, distractor and the changes of the episode of a relation. Chair|a is what changes, but for STABLE."""

    def point(at: tuple[float, float]) -> Position:
        return Position(x=at[0], y=0.5, z=at[1])

    here, target = dict(CHAIRS), "Chair|a"
    change = Change(
        instance=target, category=CATEGORY, kind="displace", before=point(here[target]), after=point(ELSEWHERE), path=None,
        placement=ELSEWHERE, height_m=0.5, roam=None,
    )  # fmt: skip
    match relation:
        case Relation.MOVED | Relation.FORMER:
            return here, here | {target: ELSEWHERE}, target, None, (change,)
        case Relation.STABLE:
            two = {k: here[k] for k in ("Chair|a", "Chair|b")}
            return two, two | {target: ELSEWHERE}, "Chair|b", target, (change,)
        case Relation.APPEARED:
            without = {k: v for k, v in here.items() if k != target}
            added = change.model_copy(update={"kind": "enable", "before": None, "after": point(here[target])})
            return without, here, target, None, (added,)
        case Relation.REMOVED:
            without = {k: v for k, v in here.items() if k != target}
            return here, without, target, None, (change.model_copy(update={"kind": "disable", "after": None}),)
        case Relation.MOVING:
            path = ((0.5, 3.0), (1.2, 3.0), (1.9, 3.0), (2.6, 2.6))
            roam = Roam.over(0.5, 3.0, 0.1, [(column, row) for column in range(22) for row in range(-4, 1)])
            motion = {"kind": "motion", "after": point(path[-1]), "path": path, "placement": None, "roam": roam}
            moving = change.model_copy(update=motion)
            return here, here | {target: path[-1]}, target, None, (moving,)


def _places(world: World, changes: Sequence[Change], view: int, second: bool) -> World:
    """Where everything is at a view: a mover is on its way during the second tour."""
    moving = {c.instance: c.path[view] for c in changes if c.path and second}
    return {k: moving.get(k, at) for k, at in world.items()} | {LAMP: (4.5, 4.0)}


def _mask(index: int) -> np.ndarray:
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[4:24, 1 + 9 * index : 8 + 9 * index] = True
    return mask


def _record_visit(directory: Path, world: World, changes: Sequence[Change], second: bool, name: str) -> Detected:
    """A recorded tour, whose views 0 and 2 show everything, and what a detector without faults makes of it."""
    directory.mkdir(parents=True)
    rng = np.random.default_rng(0)
    views, rows = [], []
    for number, (x, z, yaw) in enumerate(VIEWS):
        seen = sorted(_places(world, changes, number, second)) if number % 2 == 0 else []
        places = _places(world, changes, number, second)
        ids = np.zeros((HEIGHT, WIDTH), np.uint16)
        for k, instance in enumerate(seen):
            ids[_mask(k)] = k + 1
            feature = np.eye(2)[int(instance == LAMP)] + rng.normal(0, 0.02, 2)
            rows.append((number, (places[instance][0], 0.5, places[instance][1]), feature / np.linalg.norm(feature), _mask(k)))
        cv2.imwrite(str(directory / f"{number:02d}_rgb.png"), rng.integers(0, 255, (HEIGHT, WIDTH, 3), np.uint8))
        cv2.imwrite(str(directory / f"{number:02d}_ids.png"), ids)
        pose, camera = ViewPose(x=x, z=z, yaw_deg=yaw, horizon_deg=0.0), Position(x=x, y=1.5, z=z)
        views.append(View(pose=pose, camera=camera, instances=tuple(seen), seen=dict.fromkeys(seen, 900), moved={}))
    present = {
        k: Present(category=k.split("|")[0], position=Position(x=x, y=0.5, z=z))
        for k, (x, z) in _places(world, (), 0, False).items()
    }
    visit = Visit(scene=SCENE, visit=name, alterations=(), placed={}, present=present, movers=(), views=tuple(views))
    (directory / "visit.json").write_text(visit.to_line())
    seal(directory)
    return Detected(
        view=np.array([row[0] for row in rows]),
        point=np.array([row[1] for row in rows]),
        feature=np.array([row[2] for row in rows]),
        pixels=np.array([row[3].sum() for row in rows]),
        confidence=np.full(len(rows), 0.9, np.float32),
        packed=PackedMasks.of(np.array([row[3] for row in rows])),
        content=directory.name,
    )


def _episode(relation: Relation, visits: Mapping[str, str], settings: Settings) -> Episode:
    first, second, target, distractor, changes = _worlds(relation)
    at = (first if relation.past else second)[target]

    def world(places: World) -> WorldState:
        return WorldState(tuple(Instance(k, CATEGORY, x, z) for k, (x, z) in places.items()))

    return Episode(
        id=f"{SCENE}/{relation}/0000",
        split="main",
        backend="embedded",
        scene=SCENE,
        relation=relation,
        category=CATEGORY,
        noun=noun(CATEGORY),
        sentence=f"go to the chair of {relation}",
        target=target,
        distractor=distractor,
        changes=changes,
        tours=VisitPair[Tour](first=TOUR, second=TOUR),
        visits=VisitPair[str](**visits),
        movers=(MoverStart(instance=target, position=(2.6, 2.6), heading_deg=0),) if relation is Relation.MOVING else (),
        spawn=Spawn(x=1.0, z=1.0, yaw_deg=90.0),
        answer=at,
        nearest_navigable=(float(round(at[0])), float(round(at[1]))),
        shortest_path_m=2.5,
        reachable_box=ReachableBox(x=(0.0, 4.0), z=(0.0, 4.0)),
        instances_in_category=len(CHAIRS),
        world_1=world(first),
        world_2=world(second),
        drift_m={},
        certification=(),
        protocol=Protocol(camera=settings.camera, primitives=settings.primitives, mover=settings.mover, success=settings.success),
        provenance=Provenance(seed=0, trial="0"),
    )


def _sightings(episode: Episode) -> Sightings:
    worlds = _worlds(episode.relation)[:2]
    first, second = (
        tuple(
            Sighting(view=view, instance=k, px=900, x=x, z=z)
            for view in range(0, len(VIEWS), 2)
            for k, (x, z) in _places(worlds[v], episode.changes, view, v == 1).items()
            if k != LAMP
        )
        for v in (0, 1)
    )
    return Sightings(episode=episode.id, sightings=VisitPair[tuple[Sighting, ...]](first=first, second=second))


def _run(arm: str, seed: int, episode: Episode) -> dict[str, Any]:
    """Seed 0 finds the answer, seed 1 does not, and seed 2 abstains."""
    abstains = seed == 2
    x, z = episode.answer
    return {
        "schema": "ovman-run/1",
        "episode": episode.id,
        "arm": arm,
        "seed": seed,
        "outcome": "abstained" if abstains else "stopped",
        "stop": None if abstains else {"x": x + 2.0 * seed, "z": z, "yaw_deg": 30.0},
        "box_distance_m": None if abstains else 2.0 * seed,
        "answer_distance_m": None if abstains else 2.0 * seed,
        "navigable_distance_m": None if abstains else 2.0 * seed,
        "visible_px": None,
        "path_length_m": 0.0 if abstains else 3.0,
        "actions": 0 if abstains else 17,
        "success": seed == 0,
        "spl": 0.8333 if seed == 0 else 0.0,
    }


@pytest.fixture(scope="session")
def settings() -> Settings:
    return config.load(ROOT / "config.yaml")


@pytest.fixture(scope="session")
def made(tmp_path_factory: pytest.TempPathFactory, settings: Settings) -> Path:
    """The results directory; tests read it, and copy it to change it."""
    root = tmp_path_factory.mktemp("show") / "results"
    constants = SimpleNamespace(**{name: getattr(settings, name) for name in type(settings).model_fields})
    for folder in ("episodes", "scenes", "detections", "labels", "maps", "predictions"):
        (root / folder).mkdir(parents=True)
    episodes, found = [], {}
    for relation in Relation:
        first, second, _, _, changes = _worlds(relation)
        visits = {"first": f"first-{relation}", "second": f"second-{relation}"}
        for world, (which, name) in zip((first, second), visits.items(), strict=True):
            found[name] = _record_visit(root / "visits" / SCENE / name, world, changes, which == "second", name)
        episodes.append(_episode(relation, visits, settings))
    objects = tuple(
        SceneObject(
            id=k,
            category=k.split("|")[0],
            moveable=True,
            pickupable=False,
            receptacle=False,
            parents=(),
            position=Position(x=x, y=0.5, z=z),
            size=Position(x=0.6, y=0.9, z=0.6),
        )  # fmt: skip
        for k, (x, z) in (CHAIRS | {LAMP: (4.5, 4.0)}).items()
    )
    reachable = tuple((x / 2, z / 2) for x in range(9) for z in range(9))
    scene = Scene(
        scene=SCENE, start=(1.0, 1.0), floor_y=0.0, reachable=reachable, components=(81,),
        waypoints=tuple(WAYPOINTS), other_waypoints=tuple(WAYPOINTS), mobile=(),
        objects=objects,
    )  # fmt: skip
    (root / "scenes" / f"{SCENE}.json").write_text(scene.to_line())
    (root / "episodes" / "main.jsonl").write_text(lines(episodes))
    (root / "episodes" / "sightings.jsonl").write_text(lines(map(_sightings, episodes)))
    write_detections(root / "detections" / f"{SCENE}.npz", found)
    maps.run([root / "detections" / f"{SCENE}.npz"], constants, [root / "maps" / f"{SCENE}.npz"])
    labels.run([root / "scenes" / f"{SCENE}.json"], root / "detections", root / "visits", root / "labels")
    known = {noun(CATEGORY): np.array([1.0, 0.0]), noun("FloorLamp"): np.array([0.0, 1.0])}
    write_nouns(root / "nouns.npz", dict.fromkeys(all_nouns(), np.array([-1.0, 0.0])) | known)
    files = []
    for arm in of_kind(REFERENCE, Kind.STATIC):
        perceived = {"maps": root / "maps", "nouns": root / "nouns.npz"} if Need.MAPS in arm.needs else {}
        perceived |= {"labels": root / "labels"} if arm.reads_labels else {}
        files.append(root / "predictions" / f"{arm.name}.jsonl")
        main = root / "episodes" / "main.jsonl"
        sightings, scene_files = root / "episodes" / "sightings.jsonl", [root / "scenes" / f"{SCENE}.json"]
        of_arm = arm_job(settings, arm.name), settings_of_arm(settings, arm.name)
        predictions.run(*of_arm, main, files[-1], perceived, sightings, scene_files, root / "visits")
    runs = []
    for arm in of_kind(REFERENCE, Kind.EMBODIED):
        for seed in range(3):
            runs.append(root / "scores" / arm.name / f"seed{seed}" / f"{SCENE}.jsonl")
            runs[-1].parent.mkdir(parents=True)
            runs[-1].write_text("".join(line(_run(arm.name, seed, episode)) for episode in episodes))
    write_metrics(root / "episodes" / "main.jsonl", files, runs, constants, root / "metrics" / "main")
    return root
