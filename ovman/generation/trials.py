"""Stage `trials`: every candidate is brought about and measured (Algorithm 1, lines 2 to 8). Nothing is judged here.

A trial ends early only where the simulator refuses or where a measurement lies beyond the `measurement` bounds of config.yaml,
the loosest settings that a verdict may later be re-derived for.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ovman.models.record import read_records
from ovman.navigation import geodesic_m
from ovman.sim import measurement, visit
from ovman.sim.change import Alteration, World, dynamic
from ovman.sim.measurement import Ground
from ovman.sim.mover import Gait
from ovman.sim.session import AgentPose, Session, SimulatorError
from ovman.sim.visit import Visit
from ovman.task import Rejection, Relation
from ovman.workflow import seeds
from ovman.workflow.journal import Journal, digest
from ovman.workflow.parameter import StageSettings

SCHEMA = "ovman-trial/1"


class Trials:
    """Measures the candidates of one scene; visits of equal world states are recorded once, under `visits_dir`."""

    def __init__(self, session: Session, scene: Mapping[str, Any], constants: StageSettings, visits_dir: Path) -> None:
        self._session, self._constants, self._visits_dir = session, constants, Path(visits_dir)
        self._views = visit.tour([(w["x"], w["z"]) for w in scene["waypoints"]], constants.tour.headings)
        self._position = {o["id"]: o["position"] for o in scene["objects"]}
        self._visits: dict[str, Visit] = {}

    def _world(self, alterations: Sequence[Alteration], candidate: str) -> World:
        rng = seeds.generator(self._constants.benchmark.seed, "mover", candidate, "tour")
        return World(self._session, alterations, Gait.of(self._constants), rng, dynamic)

    def _visit(self, alterations: Sequence[Alteration], candidate: str) -> Visit:
        moving = any(a.kind == "motion" for a in alterations)
        seed = seeds.integer(self._constants.benchmark.seed, "mover", candidate, "tour") if moving else None
        name = visit.visit_name(alterations, seed)
        if name not in self._visits:
            directory = self._visits_dir / name
            key = digest(self._constants.canonical, [a.to_json() for a in alterations], seed)
            stamp = directory / "key"
            if stamp.exists() and stamp.read_text() == key:
                self._visits[name] = Visit.load(directory)
            else:
                world = self._world(alterations, candidate)
                self._visits[name] = visit.record(
                    self._session, world, name, alterations, self._views, self._constants.measurement.min_mask_px, directory, key
                )
        return self._visits[name]

    def measure(self, candidate: Mapping[str, Any]) -> dict[str, Any]:
        """The trial of a candidate: the candidate and "measured", whose "ended" names where it ended early, or is null."""
        if candidate["refused"] is not None:
            return _trial(candidate, {"ended": candidate["refused"]})
        measured: dict[str, Any] = {"ended": None}
        try:
            self._measure(candidate, measured)
        except SimulatorError as error:
            measured["ended"] = Rejection.SIMULATOR_ERROR
            measured["message"] = str(error)
        return _trial(candidate, measured)

    def _measure(self, candidate: Mapping[str, Any], measured: dict[str, Any]) -> None:
        relation = Relation(candidate["relation"])
        first = [Alteration.from_json(a) for a in candidate["first"]]
        second = [Alteration.from_json(a) for a in candidate["second"]]
        spawn = AgentPose(**candidate["spawn"])
        try:
            world = self._world(second, candidate["id"])
        except SimulatorError as error:
            measured.update(ended=Rejection.PLACEMENT_REFUSED, message=str(error))
            return
        self._placed(candidate, second, world, spawn, measured)
        if relation is Relation.MOVING:
            self._observed(candidate, relation, first, second, measured)
            mover = measured["mover"]
            world = self._world(second, candidate["id"])
            world.send_mover_to(mover["along_m"], mover["direction"])
            self._ground(candidate, relation, spawn, world.mover.position, measured)
        else:
            origin = self._position[candidate["target"]]
            answer = world.placed.get(candidate["target"], origin) if relation.current else origin
            ground = self._ground(candidate, relation, spawn, (answer["x"], answer["z"]), measured)
            if measured["ended"] is None:
                self._observed(candidate, relation, first, second, measured)
                if relation.current:
                    # What was placed may still have rolled a little during the tour; Eq. 3 answers with where it is then.
                    measured.update(_reach(ground, _last(measured["world_2"], candidate["target"])))

    def _placed(
        self, candidate: Mapping[str, Any], second: Sequence[Alteration], world: World, spawn: AgentPose, measured: dict[str, Any]
    ) -> None:
        """Displacements and clearances of what was put somewhere."""
        measured["placed"] = world.placed
        measured["displacement_m"], measured["spawn_clearance_m"] = {}, {}
        for alteration in second:
            if alteration.instance in world.placed:
                now, before = world.placed[alteration.instance], self._position[alteration.instance]
                measured["displacement_m"][alteration.instance] = round(
                    math.hypot(now["x"] - before["x"], now["z"] - before["z"]), 4
                )
                measured["spawn_clearance_m"][alteration.instance] = round(math.hypot(now["x"] - spawn.x, now["z"] - spawn.z), 4)

    def _ground(
        self,
        candidate: Mapping[str, Any],
        relation: Relation,
        spawn: AgentPose,
        answer: tuple[float, float],
        measured: dict[str, Any],
    ) -> Ground | None:
        """Reachability of the answer, mobility of the spawn, visibility from the nearest navigable cell; world 2 is in place."""
        constants, session = self._constants, self._session
        measured["spawn_free_moves"] = 0
        if not session.teleport(spawn, allowed=True):
            measured["ended"] = Rejection.SPAWN_IMMOBILE
            return None
        ground = Ground.around(session, spawn, constants.primitives.step_m)
        for quarter in range(4):
            session.teleport(AgentPose(spawn.x, spawn.z, 90.0 * quarter))
            moved = session.step("MoveAhead", allowed=True).metadata["lastActionSuccess"]
            measured["spawn_free_moves"] += int(moved)
        xs, zs = zip(*map(ground.grid.centre, ground.component), strict=True)
        measured["component_cells"] = len(ground.component)
        measured["reachable_box"] = {"x": [min(xs), max(xs)], "z": [min(zs), max(zs)]}
        measured["visible_px"] = None
        measured.update(_reach(ground, answer))
        if measured["answer_to_navigable_m"] > constants.measurement.answer_to_navigable_m:
            measured["ended"] = "beyond_measurement"
        elif relation.current:
            measured["visible_px"] = measurement.from_navigable(
                session, candidate["target"], answer, ground, tuple(constants.success.sweep_deg)
            )
            if max(measured["visible_px"].values()) < constants.measurement.visible_px:
                measured["ended"] = "beyond_measurement"
        return ground

    def _observed(
        self,
        candidate: Mapping[str, Any],
        relation: Relation,
        first: Sequence[Alteration],
        second: Sequence[Alteration],
        measured: dict[str, Any],
    ) -> None:
        """Both tours: what was recorded of the category, where its instances were, how far what was placed drifted."""
        category = candidate["category"]
        before, after = self._visit(first, candidate["id"]), self._visit(second, candidate["id"])
        measured["visits"] = {"first": before.name, "second": after.name}
        measured["sightings"] = {"first": before.sightings(category), "second": after.sightings(category)}
        measured["world_1"], measured["world_2"] = _truth(before, category), _truth(after, category)
        measured["changed"] = {
            a.instance: {"before": before.positions[-1].get(a.instance), "after": after.positions[-1].get(a.instance)}
            for a in (*first, *second)
        }
        measured["drift_m"] = {
            a.instance: round(after.drift_m(a.instance, _intended(a, self._position)), 4) for a in second if a.kind == "displace"
        }
        if relation is Relation.APPEARED:
            measured["drift_m"][candidate["target"]] = round(
                after.drift_m(
                    candidate["target"], (self._position[candidate["target"]]["x"], self._position[candidate["target"]]["z"])
                ),
                4,
            )
        measured["mover"] = after.record["mover"]


def _intended(alteration: Alteration, position: Mapping[str, Mapping[str, float]]) -> tuple[float, float]:
    return alteration.placement or (position[alteration.instance]["x"], position[alteration.instance]["z"])


def _reach(ground: Ground, answer: tuple[float, float]) -> dict[str, Any]:
    """An answer, its nearest navigable cell, and the ways from one to the other and from the spawn."""
    x, z = ground.navigable(*answer)
    return {
        "answer": {"x": round(answer[0], 4), "z": round(answer[1], 4)},
        "nearest_navigable": {"x": round(x, 4), "z": round(z, 4)},
        "answer_to_navigable_m": round(math.hypot(answer[0] - x, answer[1] - z), 4),
        "shortest_path_m": round(geodesic_m(ground.grid, ground.spawn, ground.grid.nearest(x, z)), 4),
    }


def _last(world: Sequence[Mapping[str, Any]], instance: str) -> tuple[float, float]:
    return next((e["x"], e["z"]) for e in world if e["id"] == instance)


def _truth(recorded: Visit, category: str) -> list[dict[str, Any]]:
    """Every present instance of a category where it was at the end of the visit, seen or not."""
    last = recorded.positions[-1]
    return [
        {"id": k, "category": c, "x": last[k]["x"], "z": last[k]["z"]}
        for k, c in sorted(recorded.category.items())
        if c == category
    ]


def _trial(candidate: Mapping[str, Any], measured: Mapping[str, Any]) -> dict[str, Any]:
    return {"schema": SCHEMA, "candidate": candidate, "measured": measured}


def run(candidates_file: Path, scene_file: Path, constants: StageSettings, output: Path, visits_dir: Path, journal: Path) -> None:
    """Measure every candidate of a scene; `journal` keeps finished trials."""
    scene = json.loads(scene_file.read_text())
    candidates = read_records(candidates_file)
    kept = Journal(journal)
    lines = []
    with Session(scene["scene"], constants) as session:
        trials = Trials(session, scene, constants, visits_dir)
        for candidate in candidates:
            key = digest(candidate, scene["waypoints"], constants.canonical)
            trial = kept.unit(key, lambda candidate=candidate: session.surviving(lambda: trials.measure(candidate)))
            lines.append(json.dumps(trial, separators=(",", ":")) + "\n")
            print(f"{candidate['id']}: {trial['measured']['ended'] or 'measured'}", flush=True)
    output.write_text("".join(lines))
