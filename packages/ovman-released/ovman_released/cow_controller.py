"""What CoW's released runner takes for AI2-THOR's Controller: the world of an episode's second visit, and the test at the stop.

It stands between the runner and a Controller that was started with the runner's own parameters, which say what its body is. What
the runner and its agent see of the simulator is what that Controller answers; what is added is
- the episode's change after every reset, with the mover where the recorded visit left it, which takes a step after each action of
  the agent;
- the height that the simulator has for the agent, in place of the exported one;
- objects stay in the metadata: the runner's filter would leave its target alone there;
- Stop, which AI2-THOR does not know, passes;
- the terms of Eq. 4, measured when the runner lets go of an episode.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from ovman import seeds
from ovman.env import measure_at_stop, prepare_world
from ovman.records.episode import Episode, root_seed
from ovman.records.record import Text
from ovman.records.run import InstanceTerms, Terms
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session, SimulatorError
from ovman.sim.world import World
from ovman_released.cow_episodes import runner_name

ARM = "cow_released"
IDENTITY = "robothorChallengeEpisodeId"
"""The initialization parameter in which the runner says which episode comes next."""
MOVES = frozenset({"MoveAhead", "MoveBack", "MoveLeft", "MoveRight", "RotateLeft", "RotateRight", "LookUp", "LookDown"})
"""Actions of an agent: world time goes on with them."""
STOP, FILTER, UNFILTER, TELEPORT = "Stop", "SetObjectFilter", "ResetObjectFilter", "TeleportFull"
NO_WORD_OF = frozenset(
    {"agentControllerType", "branch", "commit_id", "gpu_device", "local_executable_path", "platform", "x_display"}
)
"""Parameters with which the runner chooses a build and a display; who launches has chosen already."""

Launch = Callable[..., Any]
"""From parameters of a Controller to one that runs."""


class Verdict(Terms):
    """What the evaluator measured where the runner let go of an episode.

    name: of the episode in the runner. instances: terms of every instance of the category, for CoW's own task.
    """

    name: Text
    stopped: bool
    instances: Mapping[str, InstanceTerms] | None = None


class EpisodeController:
    """A Controller for the released runner.

    launch: starts the simulator with the parameters that are given here; episodes: by their names in the runner; seed: the
    runner's; judged: is called once for each episode, when the runner lets go of it. Raises SimulatorError where the simulator
    refuses an episode.
    """

    def __init__(
        self,
        launch: Launch,
        episodes: Mapping[str, Episode],
        seed: int,
        judged: Callable[[Verdict], None],
        **parameters: Any,
    ) -> None:
        self._episodes, self._seed, self._judged = episodes, seed, judged
        self._root = root_seed(list(episodes.values()))
        self.initialization_parameters: dict[str, Any] = {k: v for k, v in parameters.items() if k not in NO_WORD_OF}
        given = self.initialization_parameters | {"renderInstanceSegmentation": True}
        first = next(iter(episodes.values()))
        self._inner = launch(**{"scene": first.scene} | given)
        body = Embodiment(
            int(given["width"]),
            int(given["height"]),
            float(given["fieldOfView"]),
            float(given["gridSize"]),
            float(given["rotateStepDegrees"]),
            mode=str(given.get("agentMode", "default")),
        )
        self._session = Session(first.scene, first.settings, body, start=lambda backend, scene, embodiment: self._inner)
        self._session.reset()
        self._event = self._inner.last_event
        self._running: Episode | None = None
        self._stopped = False
        self._world: World | None = None

    def __getattr__(self, name: str) -> Any:
        return getattr(vars(self)["_inner"], name)

    @property
    def last_event(self) -> Any:
        """The event of the last request."""
        return self._event

    def reset(self, scene: str | None = None, **parameters: Any) -> Any:
        """The second visit of the episode that the runner has named, before the agent is put there. Its event has images."""
        self._let_go()
        name = str(self.initialization_parameters.get(IDENTITY))
        if name not in self._episodes:
            raise ValueError(f"the released runner resets for {name!r}, which is none of its {len(self._episodes)} episodes")
        episode = self._episodes[name]
        if scene is not None and scene.removesuffix("_physics") != episode.scene:
            raise ValueError(f"{name}: the released runner resets {scene}, and the episode is in {episode.scene}")
        session = self._session
        session.scene = episode.scene
        rng = seeds.generator(self._root, "mover", ARM, episode.id, self._seed)
        self._world = prepare_world(session, episode, episode.settings, rng, every_object=True)
        self._running, self._stopped = episode, False
        self._event = session.step("Pass", image=True)
        return self._event

    def step(self, action: str | Mapping[str, Any] | None = None, **arguments: Any) -> Any:
        """One request of the runner; its event has images. A body that does not fit where it is to start is a SimulatorError."""
        request = dict(action) if isinstance(action, Mapping) else {"action": action}
        request |= arguments
        name = str(request.pop("action"))
        request.pop("renderImage", None)
        if name == FILTER:
            return self._event
        if name == UNFILTER:
            self._let_go()
            return self._event
        if name == STOP:
            self._stopped = True
            self._event = self._named(self._session.step("Pass", image=True), STOP, True, "")
        elif name == TELEPORT:
            self._event = self._session.teleport(_asked(request), image=True)
        elif name in MOVES and self._world is not None and self._world.movers:
            acted = self._session.step(name, allowed=True, **request).metadata
            outcome = bool(acted["lastActionSuccess"]), str(acted["errorMessage"])
            self._world.after_action()
            self._event = self._named(self._session.step("Pass", image=True), name, *outcome)
        else:
            self._event = self._session.step(name, image=True, allowed=True, **request)
        return self._event

    def stop(self) -> None:
        """Measures the running episode and ends the simulator."""
        self._let_go()
        self._inner.stop()

    def _named(self, event: Any, action: str, success: bool, message: str) -> Any:
        """The event of a Pass as that of the action whose outcome it shows."""
        event.metadata.update(lastAction=action, lastActionSuccess=success, errorMessage=message)
        return event

    def _let_go(self) -> None:
        """Measure the episode that the runner is done with, once."""
        if self._running is None:
            return
        episode, self._running = self._running, None
        name = runner_name(episode)
        if self._stopped and self._world is not None:
            terms, instances = measure_at_stop(self._session, episode, self._world, episode.settings, any_instance=True)
            at_stop = {field: getattr(terms, field) for field in Terms.model_fields}
            self._judged(Verdict(name=name, stopped=True, instances=instances or None, **at_stop))
        else:
            self._judged(Verdict(name=name, stopped=False, **dict.fromkeys(Terms.model_fields)))


def _asked(request: Mapping[str, Any]) -> AgentPose:
    """Where a TeleportFull, in its present or its former form, puts the agent."""
    position = request.get("position", request)
    rotation = request["rotation"]
    yaw_deg = rotation["y"] if isinstance(rotation, Mapping) else rotation
    try:
        return AgentPose(float(position["x"]), float(position["z"]), float(yaw_deg), float(request.get("horizon", 0.0)))
    except (KeyError, TypeError):
        raise SimulatorError(f"the released runner puts its agent nowhere: {dict(request)}") from None
