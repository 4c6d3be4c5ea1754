"""The agent's side for what is written against `ovman.agents.interface`: an agent of a user's, or an arm of config.yaml."""

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
from ovman.perception.detected import Detected
from ovman.records.prediction import Abstention, Answer
from ovman.remote.looking import Looking
from ovman.settings import Need, Settings
from ovman.settings.benchmark import Camera, Primitives
from ovman.workflow.parameter import StageSettings
from ovman_client import messages
from ovman_client.server import METHODS, lacking

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")
DEFAULT = "default"
"""The embodiment of the benchmark."""


@dataclass(slots=True, eq=False)
class HostedContext:
    """An `AgentContext` of one run. needs: of the arm. visits: those that the run has shown until now."""

    rng: np.random.Generator
    settings: Settings
    pilot: Pilot
    looking: Looking
    needs: frozenset[Need]
    arm: str
    visits: list[Visit] = field(default_factory=list)
    privileged: PrivilegedAnswer | None = None
    answered: Answer | Abstention | None = None

    @property
    def mapper(self) -> Mapper:
        """See `AgentContext.mapper`."""
        self._allow(Need.MAPS)
        return self.looking.map

    def detections(self, visit: Visit) -> Detected:
        """See `AgentContext.detections`."""
        self._allow(Need.DETECTIONS)
        return self.looking.detections(visit)

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """See `AgentContext.made`. ValueError for what is not made outside the workflow."""
        self._allow(need)
        if need is not Need.SEGMENTS:
            raise ValueError(f"arms.{self.arm}: {need} is not made outside the workflow; run the arm in the workflow")
        first, second = self.visits
        return self.looking.segments(first, second, read)

    def noun(self, phrase: str) -> np.ndarray:
        """See `AgentContext.noun`."""
        self._allow(Need.MAPS, Need.DETECTIONS, Need.SEGMENTS, Need.NETWORKS)
        return self.looking.noun(phrase)

    def networks(self) -> tuple[Detector, Encoder]:
        """See `AgentContext.networks`."""
        self._allow(Need.NETWORKS)
        return self.looking.networks

    def _allow(self, *needs: Need) -> None:
        if not self.needs & frozenset(needs):
            raise ValueError(f"arms.{self.arm} is given no {needs[0]}; write it under needs, or as --needs {needs[0]}")


def hosted(stage: StageSettings, settings: Settings) -> Callable[[Mapping[str, Any]], HostedAgent]:
    """What makes an agent for the message `begin` of a run: of the arm of `stage`, a stage `rollouts`.

    settings: all of config.yaml, for perception. AgentError where there is no such agent.
    """
    arm, looking = stage.arm, Looking(settings)
    make = load_agent(arm.name, arm.agent)
    if (absent := lacking(make)) is not None:
        raise AgentError(f"{arm.agent} has no method {absent}; write it (docs/agents.md)")

    def begin(message: Mapping[str, Any]) -> HostedAgent:
        primitives = Primitives.model_validate({name: message[name] for name in Primitives.model_fields})
        camera, seen = settings.camera, message["camera"]
        if arm.embodiment == DEFAULT:  # a body of its own has another camera than the tours, which section `camera` is of
            camera = Camera(width_px=seen["width"], height_px=seen["height"], field_of_view_deg=seen["field_of_view_deg"])
        own = replace_sections(stage, {"camera": dict(camera), "primitives": dict(primitives)})
        drawn = {name: messages.generator(words) for name, words in message["words"].items()}
        context = HostedContext(
            drawn["picks"], own, Pilot(primitives, drawn["paths"]), looking, frozenset(map(Need, arm.needs)), arm.name
        )
        return HostedAgent(make(context), context)

    return begin


class HostedAgent:
    """An `Agent` that is told in messages."""

    def __init__(self, agent: Any, context: HostedContext) -> None:
        if absent := [name for name in METHODS if not callable(getattr(agent, name, None))]:
            raise TypeError(f"{type(agent).__name__} has no method {absent[0]}; write it (docs/agents.md)")
        self._agent, self._context = agent, context

    @property
    def looks(self) -> bool:
        """See `Agent`."""
        return bool(getattr(self._agent, "looks", True))

    def familiarise(self, visit: Mapping[str, Any]) -> None:
        """See `Agent.familiarise`."""
        self._agent.familiarise(self._kept(visit))

    def revisit(self, visit: Mapping[str, Any]) -> None:
        """See `Agent.revisit`."""
        self._agent.revisit(self._kept(visit))

    def ask(self, query: Mapping[str, Any]) -> None:
        """See `Agent.ask`."""
        asked = messages.query(query)
        self._agent.ask(Query(asked.category, Relation(asked.relation)))

    def act(self, observation: Mapping[str, Any]) -> Any:
        """See `Agent.act`."""
        return self._agent.act(_observation(observation))

    def _kept(self, message: Mapping[str, Any]) -> Visit:
        seen = messages.visit({**message, "observations": ()})
        visit = Visit(tuple(map(_observation, message["observations"])), seen.reachable, seen.content)
        self._context.visits.append(visit)
        return visit


def _observation(message: Mapping[str, Any]) -> Observation:
    seen = messages.observation(message)
    pose = CameraPose(*(getattr(seen.pose, name) for name in messages.POSE))
    return Observation(seen.rgb, seen.depth, pose, seen.field_of_view_deg, seen.last_action_succeeded, reachable=seen.reachable)
