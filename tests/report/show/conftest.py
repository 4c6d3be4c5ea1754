"""A results directory with one small episode of each relation, made by the writers and stages that make the real one."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import cv2
import numpy as np
import pytest

from ovman.analysis import metrics
from ovman.evaluation import predictions
from ovman.language import noun
from ovman.models.record import line
from ovman.models.settings import Kind, Need, Settings, of_kind
from ovman.perception import maps
from ovman.perception.detected import Detected, PackedMasks
from ovman.perception.records import write_detections, write_nouns
from ovman.task import Relation
from ovman.workflow import config
from tests.arms import REFERENCE

ROOT = Path(__file__).resolve().parents[3]
SCENE, CATEGORY = "FloorPlan1", "Chair"
HEIGHT, WIDTH = 30, 40
WAYPOINTS = [(1.0, 1.0), (3.0, 2.0)]
VIEWS = [(x, z, yaw) for x, z in WAYPOINTS for yaw in (0.0, 180.0)]
CHAIRS = {"Chair|a": (0.5, 3.0), "Chair|b": (2.5, 3.5), "Chair|c": (4.0, 0.5)}
LAMP = "Lamp|d"
ELSEWHERE = (3.5, 3.5)

World = dict[str, tuple[float, float]]


def _worlds(relation: Relation) -> tuple[World, World, str, str | None, list[dict[str, Any]]]:
    """Both worlds, target, distractor and the changes of the episode of a relation. Chair|a is what changes, but for STABLE."""

    def point(at: tuple[float, float]) -> dict[str, float]:
        return {"x": at[0], "y": 0.5, "z": at[1]}

    here, target = dict(CHAIRS), "Chair|a"
    change = {"instance": target, "kind": "displace", "before": point(here[target]), "after": point(ELSEWHERE), "path": None}
    match relation:
        case Relation.MOVED | Relation.FORMER:
            return here, here | {target: ELSEWHERE}, target, None, [change]
        case Relation.STABLE:
            two = {k: here[k] for k in ("Chair|a", "Chair|b")}
            return two, two | {target: ELSEWHERE}, "Chair|b", target, [change]
        case Relation.APPEARED:
            without = {k: v for k, v in here.items() if k != target}
            return without, here, target, None, [change | {"kind": "enable", "before": None, "after": point(here[target])}]
        case Relation.REMOVED:
            without = {k: v for k, v in here.items() if k != target}
            return here, without, target, None, [change | {"kind": "disable", "after": None}]
        case Relation.MOVING:
            path = [(0.5, 3.0), (1.2, 3.0), (1.9, 3.0), (2.6, 2.6)]
            moving = {"kind": "motion", "after": point(path[-1]), "path": [{"x": x, "z": z} for x, z in path]}
            return here, here | {target: path[-1]}, target, None, [change | moving]


def _places(world: World, changes: Sequence[Mapping[str, Any]], view: int, second: bool) -> World:
    """Where everything is at a view: a mover is on its way during the second tour."""
    moving = {c["instance"]: c["path"][view] for c in changes if c["path"] and second}
    return {k: ((moving[k]["x"], moving[k]["z"]) if k in moving else at) for k, at in world.items()} | {LAMP: (4.5, 4.0)}


def _mask(index: int) -> np.ndarray:
    mask = np.zeros((HEIGHT, WIDTH), bool)
    mask[4:24, 1 + 9 * index : 8 + 9 * index] = True
    return mask


def _record_visit(directory: Path, world: World, changes: Sequence[Mapping[str, Any]], second: bool, name: str) -> Detected:
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
        pose = {"x": x, "z": z, "yaw_deg": yaw, "horizon_deg": 0.0}
        views.append({"pose": pose, "camera": {}, "instances": seen, "seen": dict.fromkeys(seen, 900), "moved": {}})
    present = {
        k: {"category": k.split("|")[0], "position": {"x": x, "y": 0.5, "z": z}}
        for k, (x, z) in _places(world, (), 0, False).items()
    }
    (directory / "visit.json").write_text(json.dumps({"visit": name, "views": views, "present": present}))
    return Detected(
        view=np.array([row[0] for row in rows]),
        point=np.array([row[1] for row in rows]),
        feature=np.array([row[2] for row in rows]),
        pixels=np.array([row[3].sum() for row in rows]),
        confidence=np.full(len(rows), 0.9, np.float32),
        packed=PackedMasks.of(np.array([row[3] for row in rows])),
        content="",
    )


def _episode(relation: Relation, visits: Mapping[str, str]) -> dict[str, Any]:
    first, second, target, distractor, changes = _worlds(relation)
    at = (first if relation.past else second)[target]
    return {
        "schema": "ovman-episode/1",
        "id": f"{SCENE}/{relation}/0000",
        "scene": SCENE,
        "relation": str(relation),
        "category": CATEGORY,
        "noun": noun(CATEGORY),
        "sentence": f"go to the chair of {relation}",
        "target": target,
        "distractor": distractor,
        "changes": changes,
        "spawn": {"x": 1.0, "z": 1.0, "yaw_deg": 90.0},
        "answer": {"x": at[0], "z": at[1]},
        "nearest_navigable": {"x": round(at[0]), "z": round(at[1])},
        "shortest_path_m": 2.5,
        "instances_in_category": len(CHAIRS),
        "world_1": [{"id": k, "category": CATEGORY, "x": x, "z": z} for k, (x, z) in first.items()],
        "world_2": [{"id": k, "category": CATEGORY, "x": x, "z": z} for k, (x, z) in second.items()],
        "visits": dict(visits),
        "drift_m": {},
        "certification": [],
    }


def _trial(episode: Mapping[str, Any]) -> dict[str, Any]:
    worlds = _worlds(Relation(episode["relation"]))[:2]
    sightings = {
        which: [
            {"view": view, "instance": k, "px": 900, "x": x, "z": z}
            for view in range(0, len(VIEWS), 2)
            for k, (x, z) in _places(worlds[v], episode["changes"], view, v == 1).items()
            if k != LAMP
        ]
        for v, which in enumerate(("first", "second"))
    }
    measured = {"visits": episode["visits"], "sightings": sightings, "reachable_box": {"x": [0.0, 4.0], "z": [0.0, 4.0]}}
    candidate = {"id": episode["id"], "category": CATEGORY, "relation": episode["relation"]}
    return {"candidate": candidate, "measured": measured}


def _run(arm: str, seed: int, episode: Mapping[str, Any]) -> dict[str, Any]:
    """Seed 0 finds the answer, seed 1 does not, and seed 2 abstains."""
    abstains = seed == 2
    answer = episode["answer"]
    return {
        "schema": "ovman-run/1",
        "episode": episode["id"],
        "arm": arm,
        "seed": seed,
        "outcome": "abstained" if abstains else "stopped",
        "stop": None if abstains else {"x": answer["x"] + 2.0 * seed, "z": answer["z"], "yaw_deg": 30.0},
        "answer_distance_m": None if abstains else 2.0 * seed,
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
    for folder in ("episodes", "scenes", "trials", "detections", "maps", "predictions"):
        (root / folder).mkdir(parents=True)
    episodes, found = [], {}
    for relation in Relation:
        first, second, _, _, changes = _worlds(relation)
        visits = {"first": f"first-{relation}", "second": f"second-{relation}"}
        for world, (which, name) in zip((first, second), visits.items(), strict=True):
            found[name] = _record_visit(root / "visits" / SCENE / name, world, changes, which == "second", name)
        episodes.append(_episode(relation, visits))
    reachable = [[x / 2, z / 2] for x in range(9) for z in range(9)]
    objects = [
        {"id": k, "category": k.split("|")[0], "position": {"x": x, "y": 0.5, "z": z}, "size": {"x": 0.6, "y": 0.9, "z": 0.6}}
        for k, (x, z) in (CHAIRS | {LAMP: (4.5, 4.0)}).items()
    ]
    scene = {"reachable": reachable, "waypoints": [{"x": x, "z": z} for x, z in WAYPOINTS], "objects": objects}
    (root / "scenes" / f"{SCENE}.json").write_text(json.dumps(scene))
    (root / "episodes" / "main.jsonl").write_text("".join(map(line, episodes)))
    trials = root / "trials" / f"{SCENE}.jsonl"
    trials.write_text("".join(line(_trial(episode)) for episode in episodes))
    write_detections(root / "detections" / f"{SCENE}.npz", found)
    maps.run([root / "detections" / f"{SCENE}.npz"], constants, [root / "maps" / f"{SCENE}.npz"])
    write_nouns(root / "nouns.npz", {noun(CATEGORY): np.array([1.0, 0.0])})
    files = []
    for arm in of_kind(REFERENCE, Kind.STATIC):
        perceived = {"maps": [root / "maps" / f"{SCENE}.npz"], "nouns": [root / "nouns.npz"]} if Need.MAPS in arm.needs else {}
        files.append(root / "predictions" / f"{arm.name}.jsonl")
        main = root / "episodes" / "main.jsonl"
        predictions.run(arm, main, [trials], constants, files[-1], root / "visits", perceived)
    runs = []
    for arm in of_kind(REFERENCE, Kind.EMBODIED):
        for seed in range(3):
            runs.append(root / "runs" / arm.name / f"seed{seed}" / f"{SCENE}.jsonl")
            runs[-1].parent.mkdir(parents=True)
            runs[-1].write_text("".join(line(_run(arm.name, seed, episode)) for episode in episodes))
    metrics.run(root / "episodes" / "main.jsonl", files, runs, constants, root / "metrics", REFERENCE)
    return root
