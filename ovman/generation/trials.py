"""Stage `trials`: every candidate is brought about and measured (Algorithm 1, lines 2 to 8). Nothing is judged here.

A trial ends early only where the simulator refuses or where a measurement lies beyond the `measurement` bounds of config.yaml,
the loosest settings that a verdict may later be re-derived for.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from pydantic import ConfigDict

from ovman import seeds
from ovman.cache import Cache, digest
from ovman.navigation.grid import geodesic_m
from ovman.processes import Units, map_items
from ovman.records.geometry import Point, Position
from ovman.records.record import lines
from ovman.records.scene import Alteration, Scene
from ovman.records.task import Instance, Rejection, Relation, WorldState
from ovman.records.trial import Bound, Candidate, Displaced, ReachableBox, Trial, TrialMeasurement
from ovman.records.visit import Visit, VisitPair
from ovman.settings import Settings
from ovman.sim import measurement, visit
from ovman.sim.measurement import ReachableRegion
from ovman.sim.session import AgentPose, Session, SimulatorError
from ovman.sim.world import World, is_dynamic

T = TypeVar("T")


class _Draft(TrialMeasurement):
    """A measurement in progress: it keeps what was measured before the simulator refuses."""

    model_config = ConfigDict(frozen=False)

    def finished(self) -> TrialMeasurement:
        return TrialMeasurement(**dict(self))


class Trials:
    """Measures the candidates of one scene. Equal world states are toured once."""

    def __init__(self, session: Session, scene: Scene, constants: Settings) -> None:
        self._session, self._constants = session, constants
        self._waypoints = scene.waypoints
        self._position: Mapping[str, Position] = {o.id: o.position for o in scene.objects}
        self._visits: dict[str, Visit] = {}

    def _world(self, alterations: Sequence[Alteration], streams: str) -> World:
        rng = seeds.generator(self._constants.benchmark.seed, *seeds.tour_movers(streams))
        return World(self._session, alterations, self._constants.mover, rng, is_dynamic)

    def _visit(self, which: str, candidate: Candidate) -> Visit:
        alterations, tour = (candidate.first if which == "first" else candidate.second), candidate.tours[which]
        seed = visit.mover_seed(self._constants.benchmark.seed, candidate.streams, alterations)
        name = visit.visit_name(alterations, seed, tour, self._waypoints)
        if name not in self._visits:
            world, least_px = self._world(alterations, candidate.streams), self._constants.measurement.min_mask_px
            self._visits[name] = visit.observe(self._session, world, name, alterations, visit.views(tour), least_px)
        return self._visits[name]

    def measure(self, candidate: Candidate) -> Trial:
        """Return the trial of a candidate. A refusal of the simulator ends it early; its field `ended` names the reason."""
        draft = _Draft(ended=candidate.refused)
        if candidate.refused is None:
            try:
                self._measure(candidate, draft)
            except SimulatorError as error:
                draft.ended, draft.message = Rejection.SIMULATOR_ERROR, str(error)
        return Trial(candidate=candidate, measured=draft.finished())

    def _measure(self, candidate: Candidate, draft: _Draft) -> None:
        assert candidate.spawn is not None
        pose = candidate.spawn
        spawn = AgentPose(pose.x, pose.z, pose.yaw_deg)
        try:
            world = self._world(candidate.second, candidate.streams)
        except SimulatorError as error:
            moving = candidate.relation is Relation.MOVING
            draft.ended = Rejection.CANNOT_MOVE if moving else Rejection.PLACEMENT_REFUSED
            draft.message = str(error)
            return
        self._placed(world, spawn, draft)
        if any(alteration.kind == "motion" for alteration in candidate.second):
            self._observed(candidate, draft)
            world = self._world(candidate.second, candidate.streams)
            world.send_movers_to(draft.movers)
            # Where a run begins, a mover is neither where it stood nor in the way.
            from_movers_m = {mover.instance: round(math.dist(mover.position, (spawn.x, spawn.z)), 4) for mover in draft.movers}
            if candidate.pair is None:
                draft.spawn_clearance_m = from_movers_m
            else:
                draft.spawn_clearance_m = {**_made(draft.spawn_clearance_m), **from_movers_m}
            answer = _made(draft.world_1 if candidate.relation.past else draft.world_2)[candidate.target].position
            if candidate.target in world.movers:
                answer = world.movers[candidate.target].position
            self._ground(candidate, spawn, answer, draft)
            return
        origin = self._position[candidate.target]
        place = world.placed.get(candidate.target, origin) if candidate.relation.current else origin
        region = self._ground(candidate, spawn, (place.x, place.z), draft)
        if region is not None and draft.ended is None:
            self._observed(candidate, draft)
            if candidate.relation.current:
                # What was placed may still have rolled a little during the tour; Eq. 3 answers with where it is then.
                _reach(region, _made(draft.world_2)[candidate.target].position, draft)

    def _placed(self, world: World, spawn: AgentPose, draft: _Draft) -> None:
        """Displacements of what was put somewhere, and its distances from the spawn."""
        draft.placed = dict(world.placed)
        before = {k: self._position[k] for k in world.placed}
        draft.displacement_m = {
            k: round(math.hypot(now.x - before[k].x, now.z - before[k].z), 4) for k, now in world.placed.items()
        }
        draft.spawn_clearance_m = {k: round(math.hypot(now.x - spawn.x, now.z - spawn.z), 4) for k, now in world.placed.items()}

    def _ground(self, candidate: Candidate, spawn: AgentPose, answer: Point, draft: _Draft) -> ReachableRegion | None:
        """Reachability of the answer, mobility of the spawn, visibility from the nearest navigable cell; world 2 is in place.

        None where the spawn is not free.
        """
        constants, session = self._constants, self._session
        draft.spawn_free_moves = 0
        if not session.teleport(spawn, allowed=True):
            draft.ended = Rejection.SPAWN_IMMOBILE
            return None
        region = ReachableRegion.around(session, spawn, constants.primitives.step_m)
        for quarter in range(4):
            session.teleport(AgentPose(spawn.x, spawn.z, 90.0 * quarter))
            moved = session.step("MoveAhead", allowed=True).metadata["lastActionSuccess"]
            draft.spawn_free_moves += int(moved)
        xs, zs = zip(*map(region.grid.centre, region.component), strict=True)
        draft.component_cells = len(region.component)
        draft.reachable_box = ReachableBox(x=(min(xs), max(xs)), z=(min(zs), max(zs)))
        to_navigable_m = _reach(region, answer, draft)
        if candidate.relation.current:
            box_m = measurement.box_distance_m(spawn.x, spawn.z, session.objects[candidate.target])
            draft.spawn_to_box_m = round(box_m, 4)
        if to_navigable_m > constants.measurement.answer_to_navigable_m:
            draft.ended = Bound.BEYOND_MEASUREMENT
        elif candidate.relation.current:
            seen = measurement.from_navigable(session, candidate.target, answer, region, tuple(constants.success.sweep_deg))
            draft.visible_px = seen
            if max(seen.values()) < constants.measurement.visible_px:
                draft.ended = Bound.BEYOND_MEASUREMENT
        return region

    def _observed(self, candidate: Candidate, draft: _Draft) -> None:
        """Both tours: what was recorded of the category, where its instances were, how far what was placed drifted."""
        category = candidate.category
        before, after = self._visit("first", candidate), self._visit("second", candidate)
        draft.visits = VisitPair[str](first=before.visit, second=after.visit)
        draft.sightings = VisitPair(first=before.sightings(category), second=after.sightings(category))
        draft.world_1, draft.world_2 = _truth(before, category), _truth(after, category)
        draft.changed = {
            a.instance: Displaced(before=before.positions[-1].get(a.instance), after=after.positions[-1].get(a.instance))
            for a in candidate.first + candidate.second
        }
        drift_m = {
            a.instance: round(visit.drift_m(after, a.instance, _made(a.placement)), 4)
            for a in candidate.second
            if a.kind == "displace"
        }
        for alteration in candidate.first:  # gone in visit 1, in visit 2 where the untouched scene has it
            origin = self._position[alteration.instance]
            drift_m[alteration.instance] = round(visit.drift_m(after, alteration.instance, (origin.x, origin.z)), 4)
        draft.drift_m = drift_m
        draft.movers = after.movers
        if candidate.others:
            draft.other_px = {k: VisitPair[int](first=before.largest_px(k), second=after.largest_px(k)) for k in candidate.others}


def _made(value: T | None) -> T:
    assert value is not None
    return value


def _reach(region: ReachableRegion, answer: Point, draft: _Draft) -> float:
    """Note an answer, its nearest navigable cell, their distance, which is returned, and the length of the way from the spawn."""
    x, z = region.navigable(*answer)
    draft.answer = round(answer[0], 4), round(answer[1], 4)
    draft.nearest_navigable = round(x, 4), round(z, 4)
    to_navigable_m = round(math.hypot(answer[0] - x, answer[1] - z), 4)
    draft.answer_to_navigable_m = to_navigable_m
    draft.shortest_path_m = round(_made(geodesic_m(region.grid, region.spawn, region.grid.nearest(x, z))), 4)
    return to_navigable_m


def _truth(recorded: Visit, category: str) -> WorldState:
    """Return every present instance of a category where it was at the end of the visit, seen or not."""
    last = recorded.positions[-1]
    return WorldState(
        tuple(
            Instance(k, category, last[k].x, last[k].z) for k, one in sorted(recorded.present.items()) if one.category == category
        )
    )


def run(scenes_file: Path, candidates_file: Path, settings: Settings, output: Path, cache: Cache, workers: int = 1) -> None:
    """Measure every candidate and write the trials, scene by scene. workers: Number of processes over the scenes."""
    by_scene: dict[str, list[Candidate]] = {}
    for candidate in Candidate.read(candidates_file):
        by_scene.setdefault(candidate.scene, []).append(candidate)
    work = [(scene.to_line(), lines(by_scene.get(scene.scene, ()))) for scene in Scene.read(scenes_file)]
    measure = partial(_measure_scene, settings=settings, cache=cache)
    output.write_text("".join(map_items(measure, work, workers)), encoding="utf-8")


def _measure_scene(work: tuple[str, str], settings: Settings, cache: Cache) -> str:
    """Return the trials of a scene as lines. work: The scene and its candidates as lines."""
    scene = Scene.parse(work[0])
    candidates = [Candidate.parse(line) for line in work[1].splitlines()]
    done, units = [], Units(len(candidates))
    waypoints = [dict(zip("xz", at, strict=True)) for at in scene.waypoints]
    with Session(scene.scene, settings) as session:
        trials = Trials(session, scene, settings)

        def measure(candidate: Candidate) -> dict[str, Any]:
            return session.with_restarts(lambda: trials.measure(candidate).to_json())

        for candidate in candidates:
            key = digest(candidate.to_json(), waypoints, settings.constants())
            done.append(Trial.from_json(cache.get_or_compute(key, partial(measure, candidate))))
            units.done(f"{candidate.id}: {done[-1].measured.ended or 'measured'}")
    return lines(done)
