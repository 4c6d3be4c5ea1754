"""The agent's side for agents of `ovman.agents.interface`: a user's agent, or an arm of config.yaml."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import CameraPose, Mapper, Observation, PrivilegedAnswer, Query, Relation, Visit
from ovman.agents.pilot import Pilot
from ovman.evaluation.context import replace_sections
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.perception.records import Detected
from ovman.records.prediction import Abstention, Answer
from ovman.remote.perception import PerceptionPipeline
from ovman.settings import Need, Settings
from ovman.settings.benchmark import Camera, Primitives
from ovman.settings.jobs import arm_job, settings_of_arm
from ovman_client import messages
from ovman_client.server import lacking

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")
DEFAULT = "default"
"""The embodiment of the benchmark."""


@dataclass(slots=True, eq=False)
class HostedContext:
    """An `AgentContext` of one run. needs: Of the arm. visits: Those that the run has shown until now."""

    rng: np.random.Generator
    settings: Settings
    pilot: Pilot
    perception: PerceptionPipeline
    needs: frozenset[Need]
    arm: str
    visits: list[Visit] = field(default_factory=list)
    privileged: PrivilegedAnswer | None = None
    answered: Answer | Abstention | None = None

    @property
    def mapper(self) -> Mapper:
        """See `AgentContext.mapper`."""
        self._check_needs(Need.MAPS)
        return self.perception.map

    def detections(self, visit: Visit) -> Detected:
        """See `AgentContext.detections`."""
        self._check_needs(Need.DETECTIONS)
        return self.perception.detections(visit)

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """See `AgentContext.made`. ValueError for files that only the workflow makes."""
        self._check_needs(need)
        if need is not Need.SEGMENTS:
            raise ValueError(f"arms.{self.arm}: {need} is not made outside the workflow; run the arm in the workflow")
        first, second = self.visits
        return self.perception.segments(first, second, read)

    def noun(self, phrase: str) -> np.ndarray:
        """See `AgentContext.noun`."""
        self._check_needs(Need.MAPS, Need.DETECTIONS, Need.SEGMENTS, Need.NETWORKS)
        return self.perception.noun(phrase)

    def networks(self) -> tuple[Detector, Encoder]:
        """See `AgentContext.networks`."""
        self._check_needs(Need.NETWORKS)
        return self.perception.networks

    def _check_needs(self, *needs: Need) -> None:
        if not self.needs & frozenset(needs):
            raise ValueError(f"arms.{self.arm} is given no {needs[0]}; write it under needs, or as --needs {needs[0]}")


class HostedAgent:
    """An `Agent` that is called by messages."""

    def __init__(self, agent: Any, context: HostedContext) -> None:
        self._agent, self._context = agent, context

    @property
    def looks(self) -> bool:
        """See `Agent`."""
        return bool(getattr(self._agent, "looks", True))

    def familiarise(self, visit: Mapping[str, Any]) -> None:
        """Call `Agent.familiarise`."""
        self._agent.familiarise(self._keep(visit))

    def revisit(self, visit: Mapping[str, Any]) -> None:
        """Call `Agent.revisit`."""
        self._agent.revisit(self._keep(visit))

    def ask(self, query: Mapping[str, Any]) -> None:
        """Call `Agent.ask`."""
        asked = messages.query(query)
        self._agent.ask(Query(asked.category, Relation(asked.relation)))

    def act(self, observation: Mapping[str, Any]) -> Any:
        """Call `Agent.act`."""
        return self._agent.act(_observation(observation))

    def _keep(self, message: Mapping[str, Any]) -> Visit:
        seen = messages.visit({**message, "observations": ()})
        visit = Visit(tuple(map(_observation, message["observations"])), seen.reachable, seen.content)
        self._context.visits.append(visit)
        return visit


def host_arm(settings: Settings, name: str) -> Callable[[Mapping[str, Any]], HostedAgent]:
    """Return the function that makes the agent of an arm for the message `begin` of a run. AgentError if there is no such agent.

    settings: All of config.yaml.
    """
    arm, of_arm, perception = arm_job(settings, name), settings_of_arm(settings, name), PerceptionPipeline(settings)
    make = load_agent(name, arm.agent)
    if (absent := lacking(make)) is not None:
        raise AgentError(f"{arm.agent} has no method {absent}; write it (docs/agents.md)")

    def begin(message: Mapping[str, Any]) -> HostedAgent:
        primitives = Primitives.model_validate({key: message[key] for key in Primitives.model_fields})
        camera, seen = settings.camera, message["camera"]
        if arm.embodiment == DEFAULT:  # another body has another camera than the tours, which section `camera` describes
            camera = Camera(width_px=seen["width"], height_px=seen["height"], field_of_view_deg=seen["field_of_view_deg"])
        own = replace_sections(of_arm, {"camera": dict(camera), "primitives": dict(primitives)})
        picks, paths = (messages.generator(message["words"][draws]) for draws in ("picks", "paths"))
        context = HostedContext(picks, own, Pilot(primitives, paths), perception, frozenset(arm.needs), arm.name)
        return HostedAgent(make(context), context)

    return begin


def _observation(message: Mapping[str, Any]) -> Observation:
    seen = messages.observation(message)
    pose = CameraPose(*(getattr(seen.pose, name) for name in messages.POSE))
    return Observation(seen.rgb, seen.depth, pose, seen.field_of_view_deg, seen.last_action_succeeded, reachable=seen.reachable)
