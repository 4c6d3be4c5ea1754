"""The agent's side for agents of `ovman.agents.interface`: a user's agent, or an arm of config.yaml."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import ovman_client
from ovman.agents.interface import CameraPose, Instruction, Observation, Query, Relation, Visit
from ovman.agents.pilot import Pilot
from ovman.evaluation.context import RolloutContext, replace_sections
from ovman.evaluation.supervision import AgentError, load_agent
from ovman.remote.perception import PerceptionPipeline
from ovman.settings import Settings
from ovman.settings.benchmark import Camera, Primitives
from ovman.settings.settings import arm_job, settings_of_arm
from ovman_client import messages
from ovman_client.server import lacking

DEFAULT = "default"
"""The embodiment of the benchmark."""


class HostedAgent:
    """An `Agent` that is called by messages."""

    def __init__(self, agent: Any, visits: list[Visit]) -> None:
        """Wrap an agent. visits: Gets those that the run shows."""
        self._agent, self._visits = agent, visits

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
        words = {"sentence": asked.sentence, "phrase": asked.phrase}
        if isinstance(asked, ovman_client.Instruction):
            self._agent.ask(Instruction(**words))
        else:
            self._agent.ask(Query(asked.category, Relation(asked.relation), **words))

    def act(self, observation: Mapping[str, Any]) -> Any:
        """Call `Agent.act`."""
        return self._agent.act(_observation(observation))

    def _keep(self, message: Mapping[str, Any]) -> Visit:
        seen = messages.visit({**message, "observations": ()})
        visit = Visit(tuple(map(_observation, message["observations"])), seen.reachable, seen.content)
        self._visits.append(visit)
        return visit


def host_arm(settings: Settings, name: str) -> Callable[[Mapping[str, Any]], HostedAgent]:
    """Return the function that makes the agent of an arm for the message `begin` of a run. AgentError if there is no such agent.

    settings: All of config.yaml.
    """
    arm, of_arm = arm_job(settings, name), settings_of_arm(settings, name)
    perception, make = PerceptionPipeline(settings, arm), load_agent(name, arm.agent)
    if (absent := lacking(make)) is not None:
        raise AgentError(f"{arm.agent} has no method {absent}; write it (docs/agents.md)")

    def begin(message: Mapping[str, Any]) -> HostedAgent:
        primitives = Primitives.model_validate({key: message[key] for key in Primitives.model_fields})
        camera, seen = settings.camera, message["camera"]
        if arm.embodiment == DEFAULT:  # another body has another camera than the tours, which section `camera` describes
            camera = Camera(width_px=seen["width"], height_px=seen["height"], field_of_view_deg=seen["field_of_view_deg"])
        own = replace_sections(of_arm, {"camera": dict(camera), "primitives": dict(primitives)})
        picks, paths = (messages.generator(message["words"][draws]) for draws in ("picks", "paths"))
        pilot, visits = Pilot(primitives, paths, message.get("grid") == "first"), list[Visit]()
        inputs = perception.mapper, perception.detections, partial(perception.made, visits), perception.noun, perception.networks
        return HostedAgent(make(RolloutContext(picks, own, pilot, *inputs)), visits)

    return begin


def _observation(message: Mapping[str, Any]) -> Observation:
    seen = messages.observation(message)
    pose = CameraPose(*(getattr(seen.pose, name) for name in messages.POSE))
    return Observation(seen.rgb, seen.depth, pose, seen.field_of_view_deg, seen.last_action_succeeded, reachable=seen.reachable)
