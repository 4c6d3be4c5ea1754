"""Tours of a real scene before and after a chair was moved, with true masks as detections: features say which instance it is."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from ovman.agents.interface import Abstention, Answer, Visit
from ovman.evaluation.recorded_tours import load_visit
from ovman.perception.backprojection import median_points
from ovman.perception.records import Detected
from ovman.perception.tour_files import picture, tour
from ovman.records.scene import Alteration
from ovman.records.visit import Visit as Record
from ovman.records.visit import tour_path
from ovman.settings.benchmark import Mover
from ovman.sim import visit
from ovman.sim.session import AgentPose, Session
from ovman.sim.world import World, position
from tests import arms
from tests.shared import made_once

CONFIG = arms.CONFIG.with_values({"camera.width_px": 150, "camera.height_px": 150})
SCENE, CHAIR, LENS = "FloorPlan16", "Chair", CONFIG.camera.field_of_view_deg
WIDE = 2.0
"""Metres within which places are seen from the stands of the tours."""


@dataclass(frozen=True, slots=True, eq=False)
class Toured:
    """A tour, its detections, and of each detection the number of the instance, which is where its feature is 1."""

    visit: Visit
    detected: Detected
    instance: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class Home:
    """Both tours, where the chair was and where it is, and the feature (K,) of the chair."""

    before: Toured
    after: Toured
    old: tuple[float, float]
    new: tuple[float, float]
    chair: np.ndarray


def home(factory: pytest.TempPathFactory) -> Home:
    """The tours, recorded once."""
    directory = made_once(factory, "moved_chair", _record)
    with np.load(directory / "places.npz") as places:
        cells, old, new, chair = (places[name] for name in ("cells", "old", "new", "chair"))
    tours = [Record.load(tour_path(directory, which)) for which in ("before", "after")]
    names = sorted({name for tour in tours for view in tour.views for name in view.instances})
    before, after = (_toured(tour_path(directory, which), names, cells) for which in ("before", "after"))
    return Home(before, after, tuple(old.tolist()), tuple(new.tolist()), np.eye(len(names))[names.index(str(chair))])


def off(found: Answer | Abstention, at: tuple[float, float]) -> float:
    """Metres between an answer and a place."""
    return math.dist((found.x, found.z), at) if isinstance(found, Answer) else math.inf


def _record(directory: Path) -> None:
    """The tours go around the chair's old place and its new one, near enough for points of it."""
    mover = Mover(step_m=0.1, pause_probability=0.0, turn_probability=0.0)
    with Session(SCENE, CONFIG) as session:
        session.reset()
        cells = np.array(session.reachable())
        chair, old = next((k, position(o)) for k, o in sorted(session.objects.items()) if o["objectType"] == CHAIR)
        start, floor = session.pose, np.array([(old.x, old.z)])
        barred = np.hypot(*(cells - floor).T) < WIDE
        barred |= np.hypot(*(cells - (start.x, start.z)).T) < 1.2
        free = np.array([np.sum(np.hypot(*(cells - cell).T) < 0.6) for cell in cells])
        new = cells[int(np.argmax(np.where(barred, 0, free)))]
        stands = []
        for place in (floor[0], new):
            away = np.abs(np.hypot(*(cells - place).T) - 1.3) + 10.0 * (np.hypot(*(cells - new).T) < 0.8)
            stands += [cells[k] for k in np.argsort(away, kind="stable")[:2]]
        moved = (Alteration(kind="displace", instance=chair, placement=tuple(map(float, new)), height_m=0.5),)
        for name, alterations in (("before", ()), ("after", moved)):
            world = World(session, alterations, mover, np.random.default_rng(0))
            views = [AgentPose(float(x), float(z), 90.0 * k) for x, z in stands for k in range(4)]
            visit.record(session, world, name, alterations, views, 1, tour_path(directory, name), name)
        now = position(session.objects[chair])
    np.savez(directory / "places.npz", cells=cells, old=(old.x, old.z), new=(now.x, now.z), chair=chair)


def _toured(directory: Path, names: list[str], cells: np.ndarray) -> Toured:
    views, instances, masks, points = [], [], [], []
    for number, (view, seen) in enumerate(zip(tour(directory, LENS), Record.load(directory).views, strict=True)):
        ids = picture(directory, number, "ids")
        for k, name in enumerate(seen.instances, start=1):
            mask = ids == k
            if np.count_nonzero(mask) >= CONFIG.perception.detector.min_mask_px:
                views.append(number)
                instances.append(names.index(name))
                masks.append(mask)
                points.append(median_points(view.depth, mask[None], view.camera)[0])
    every = np.stack(masks)
    detected = Detected(
        view=np.array(views),
        point=np.stack(points),
        feature=np.eye(len(names), dtype=np.float32)[instances],
        pixels=every.sum(axis=(1, 2)),
        confidence=np.ones(len(every), np.float32),
        masks=lambda: every,
        content=directory.name,
    )
    return Toured(load_visit(directory, LENS, cells), detected, np.array(instances))
