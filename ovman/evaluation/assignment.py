"""What the evaluator knows of an episode that an agent runs: the world of its second visit, and the test at the stop."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ovman.models.settings import Settings
from ovman.sim import measurement
from ovman.sim.change import Alteration, World
from ovman.sim.measurement import Ground
from ovman.sim.mover import Gait
from ovman.sim.session import AgentPose, Session
from ovman.task import Relation


@dataclass(frozen=True)
class Assignment:
    """The truth, which the agent does not see.

    answer: floor-plane point in metres, for MOVING where the mover is when the run begins; mover: its "along_m" and "direction"
    at that moment, None where nothing moves; navigable: nu(a), the cell nearest to the answer that the benchmark's own body can
    reach.
    """

    relation: Relation
    category: str
    target: str
    second: tuple[Alteration, ...]
    spawn: AgentPose
    answer: tuple[float, float]
    navigable: tuple[float, float]
    mover: Mapping[str, Any] | None

    @staticmethod
    def of(trial: Mapping[str, Any]) -> Assignment:
        """The assignment of a measured trial."""
        candidate, measured = trial["candidate"], trial["measured"]
        return Assignment(
            Relation(candidate["relation"]),
            candidate["category"],
            candidate["target"],
            tuple(Alteration.from_json(a) for a in candidate["second"]),
            AgentPose(**candidate["spawn"]),
            (measured["answer"]["x"], measured["answer"]["z"]),
            (measured["nearest_navigable"]["x"], measured["nearest_navigable"]["z"]),
            measured["mover"],
        )

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
        told: Callable[[Mapping[str, Any]], bool] | None = None,
    ) -> World:
        """The world of the second visit, with the mover where the recorded visit left it; `rng` drives it. told: as for World.

        SimulatorError if the simulator refuses.
        """
        world = World(session, self.second, Gait.of(constants), rng, told)
        if self.mover is not None:
            world.send_mover_to(self.mover["along_m"], self.mover["direction"])
        return world

    def at_stop(
        self, session: Session, world: World, constants: Settings, ground: Ground | None = None, any_instance: bool = False
    ) -> dict[str, Any]:
        """The terms of Eq. 4 where the agent stands, and with any_instance those of every instance of the category ("instances").

        ground: what the agent could reach from its spawn; without it `navigable` holds. Where something moves, its place of now
        is the answer, and nu(a) is found anew.
        """
        answer, navigable = self.answer, self.navigable
        if world.mover is not None:
            answer = world.mover.position
            ground = Ground.around(session, session.pose, constants.primitives.step_m)
        if ground is not None:
            navigable = ground.navigable(*answer)
        instances: list[str] = []
        if any_instance:
            gone = self.gone
            instances = [k for k, o in session.objects.items() if self.concerns(o) and k not in gone]
        sweep = tuple(constants.success.sweep_deg)
        return measurement.at_stop(session, self.relation.past, self.target, answer, navigable, sweep, instances)
