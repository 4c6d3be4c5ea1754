"""What the evaluator knows of an episode that an agent runs: the world of its second visit, and the test at the stop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.models.change import Alteration, MoverStart
from ovman.models.geometry import Point
from ovman.models.relation import Relation
from ovman.models.run import InstanceTerms, Terms
from ovman.models.settings import Settings
from ovman.models.trial import Trial
from ovman.sim import measurement
from ovman.sim.change import World
from ovman.sim.measurement import ReachableRegion
from ovman.sim.session import AgentPose, Session


@dataclass(frozen=True)
class Assignment:
    """The truth, which the agent does not see.

    answer: floor-plane point in metres, for MOVING where the mover is when the run begins; mover: its state at that moment, None
    where nothing moves; navigable: nu(a), the cell nearest to the answer that the benchmark's own body can reach.
    """

    relation: Relation
    category: str
    target: str
    second: tuple[Alteration, ...]
    spawn: AgentPose
    answer: Point
    navigable: Point
    mover: MoverStart | None

    @property
    def gone(self) -> frozenset[str]:
        """The instances that are not there any more."""
        return frozenset(a.instance for a in self.second if a.kind == "disable")

    def concerns(self, metadata: Mapping[str, Any]) -> bool:
        """Whether an object is of the category."""
        return bool(metadata["objectType"] == self.category)

    def begun(
        self,
        session: Session,
        constants: Settings,
        rng: np.random.Generator,
        object_filter: Callable[[Mapping[str, Any]], bool] | None = None,
    ) -> World:
        """The world of the second visit, with the mover where the recorded visit left it; `rng` drives it.

        object_filter: as for World.

        SimulatorError if the simulator refuses.
        """
        world = World(session, self.second, constants.mover, rng, object_filter)
        if self.mover is not None:
            world.send_mover_to(self.mover.along_m, self.mover.direction)
        return world

    def at_stop(
        self,
        session: Session,
        world: World,
        constants: Settings,
        region: ReachableRegion | None = None,
        any_instance: bool = False,
    ) -> tuple[Terms, Mapping[str, InstanceTerms]]:
        """The terms of Eq. 4 where the agent stands, and with any_instance those of every instance of the category.

        region: what the agent could reach from its spawn; without it `navigable` holds. Where something moves, its place of now
        is the answer, and nu(a) is found anew.
        """
        answer, navigable = self.answer, self.navigable
        if world.mover is not None:
            answer = world.mover.position
            region = ReachableRegion.around(session, session.pose, constants.primitives.step_m)
        if region is not None:
            navigable = region.navigable(*answer)
        instances: list[str] = []
        if any_instance:
            gone = self.gone
            instances = [k for k, o in session.objects.items() if self.concerns(o) and k not in gone]
        sweep = tuple(constants.success.sweep_deg)
        return measurement.at_stop(session, self.relation.past, self.target, answer, navigable, sweep, instances)


def assignment_of(trial: Trial) -> Assignment:
    """The assignment of a trial that was measured to its end. ValueError for one that ended early."""
    candidate, measured = trial.candidate, trial.measured
    if candidate.spawn is None or measured.answer is None or measured.nearest_navigable is None:
        raise ValueError(f"{candidate.id}: the trial ended early and cannot be run")
    return Assignment(
        candidate.relation,
        candidate.category,
        candidate.target,
        candidate.second,
        AgentPose(candidate.spawn.x, candidate.spawn.z, candidate.spawn.yaw_deg),
        measured.answer,
        measured.nearest_navigable,
        None if measured.mover is None else measured.mover.start,
    )
