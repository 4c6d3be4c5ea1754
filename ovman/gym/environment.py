"""The environment "OVMAN-v1": one run of one episode from reset to end, as `ovman eval` makes it."""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Any, SupportsInt

import gymnasium
import numpy as np
from gymnasium.error import InvalidAction, ResetNeeded

from ovman.agents.interface import VISITS, Observation, Visit
from ovman.analysis.outcomes import Case, embodied_outcomes
from ovman.analysis.rates import embodied_rates
from ovman.entry.beside import set_beside
from ovman.entry.defaults import CONFIG, DATA
from ovman.entry.release import Release
from ovman.entry.tables import of_arm, table
from ovman.env import Env
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.tours import TourCache
from ovman.gym.encoding import encoded, encoded_tour
from ovman.gym.questions import Order, questions, terms, views_of
from ovman.gym.spaces import ACTIONS, action_space, observation_space
from ovman.perception.libraries import cache as user_cache
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.remote.host import HostedContext
from ovman.remote.looking import Looking
from ovman.runner import Run, open_env, open_session
from ovman.settings import MAIN, Kind, Need
from ovman.settings.arms import ArmJob
from ovman.sim.session import Session

TOURS = ("observation", "reset")
"""Where the tours are: in every observation, or in what `reset` tells beside its own."""
SEEDS = 2**31
"""Seeds of runs that are drawn are below it."""
KEPT = 2
"""Visits that are kept, of 15 MB each: episodes of a scene have the first in common, seeds of an episode have both."""


class Environment(gymnasium.Env[dict[str, Any], np.int64]):
    """Embodied runs on released episodes.

    split: of the release, `main` where neither it nor `episodes`, a file, is named. scenes: episodes of these floor plans alone.
    name: what the draws of movers and sensors follow from, beside episode and seed: that of the agent in its records
    (`ovman eval --name`), or an arm of config.yaml that drives from tours and what is made of them, whose budget counts as well.
    looks: whether observations have pictures; without, nothing is drawn. tours: in every "observation", or, as they are constant,
    in the information of "reset" alone. cache, release, config: as of `ovman eval`. Starts no simulator before its first reset,
    and has one at a time. ValueError, in one line, for what does not exist.

    A reset with a seed is the run under that seed, as `ovman eval --seeds` makes it, and seeds the generator that episodes and
    seeds of later resets are drawn from. An action is a number in `ovman.gym.spaces.ACTIONS`; what is observed is in
    `ovman.gym.encoding`. The reward is 1.0 at a stop that succeeds (Eq. 4) and 0.0 else. A run is terminated by a stop, by an
    abstention, and by moving nowhere for too long, and truncated by its budget. Nothing is looked at after its end: the
    last observation is the one before the last action.
    """

    metadata = {"render_modes": ["rgb_array"], "render_fps": 4}

    def __init__(
        self,
        split: str | None = None,
        episodes: str | Path | None = None,
        scenes: Sequence[str] = (),
        name: str = "gym",
        looks: bool = True,
        tours: str = TOURS[0],
        cache: str | Path | None = None,
        release: str | Path | None = None,
        config: str | Path | None = None,
        render_mode: str | None = None,
    ) -> None:
        if tours not in TOURS:
            raise ValueError(f"tours: {tours!r} is no place of them; write one of {', '.join(TOURS)}")
        if render_mode is not None and (render_mode not in self.metadata["render_modes"] or not looks):
            raise ValueError(f"render_mode: {render_mode!r} cannot be rendered; write rgb_array, and looks=True")
        if split is not None and episodes is not None:
            raise ValueError("split and episodes exclude each other; write one of them")
        settings, self._stage = terms(Path(config or CONFIG), name)
        self._release = Release(Path(release or DATA), settings)
        if split is None and episodes is None:
            split = MAIN
        found = questions(self._release, split, None if episodes is None else Path(episodes), scenes)
        self._order = Order(found)
        self._camera = found[0].protocol.camera
        self._looks, self._told = looks, tours == "reset"
        self._tours = TourCache(user_cache() if cache is None else Path(cache).absolute(), logging.getLogger(__name__).info)
        self.render_mode = render_mode
        self.action_space = action_space()
        self.observation_space = observation_space(self._camera, views_of(found[0]), looks, not self._told)
        self._session: Session | None = None
        self._env: Env | None = None
        self._attempt: Run | None = None
        self._run: Score | None = None
        self._kept: OrderedDict[str, Mapping[str, np.ndarray]] = OrderedDict()
        self._given: Mapping[str, np.ndarray] = {}

    @property
    def episode_ids(self) -> tuple[str, ...]:
        """Ids of all its episodes, in the order of their file; a reset may name one. They hold scene and relation."""
        return self._order.ids

    @property
    def run(self) -> Score | None:
        """The run that has ended, judged, as a line of `runs.jsonl`; None until then."""
        return self._run

    @property
    def arm(self) -> ArmJob:
        """As what it makes its runs: name, needs, budget."""
        return self._stage.arm

    def rates(self, runs: Sequence[Score]) -> str:
        """The table of these runs by relation that `ovman eval` prints. ValueError unless each seed has every episode once."""
        asked = [self._order.by_id[name] for name in dict.fromkeys(run.episode for run in runs)]
        outcomes = embodied_outcomes([Case.of(episode) for episode in asked], runs)
        rates = embodied_rates(outcomes, self._release.settings.evaluation.confidence)
        chance = set_beside(outcomes, Kind.EMBODIED, None, self._release).chance
        return "\n".join(table(of_arm(rates, chance), markdown=False))

    def context(self) -> HostedContext:
        """An `AgentContext` for the present run: what an agent of `ovman.agents.interface` is made with.

        What it gives beside draws and constants is made of the visits that are put into it. ResetNeeded before the first reset.
        """
        if self._attempt is None:
            raise ResetNeeded("no run has begun; call reset")
        own = self._attempt.context()
        return HostedContext(own.rng, own.settings, own.pilot, self._looking, frozenset(map(Need, self.arm.needs)), self.arm.name)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin a run: of the next episode, {"episode": id}, or a drawn one of {"scene": name}.

        Its seed is the one that is given, else one that is drawn. Information: `episode`, its id; `scene`; `seed`; `category` and
        `relation`, the query in words; `field_of_view_deg`, vertical; and the tours under the keys that they else have in an
        observation. ValueError for other options, SimulatorError or SimulatorDied of the simulator, each in one line.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._order.restart()
        episode = self._order.next(options or {}, self.np_random)
        self._end()
        self._attempt = self._attempted(episode, int(self.np_random.integers(SEEDS)) if seed is None else seed)
        # A simulator that dies until the first look is replaced; later its run cannot go on.
        self._live_session.with_restarts(self._begin)
        visits = self._attempt.tour("first", np.empty((0, 2))), self._attempt.tour("second", self._reachable)
        shown = zip(VISITS, map(self._tour, visits), strict=True)
        self._given = {f"{which}_{part}": array for which, tour in shown for part, array in tour.items()}
        info = {"episode": episode.id, "scene": episode.scene, "seed": self._attempt.seed}
        info |= {"category": episode.category, "relation": str(episode.relation)}
        info["field_of_view_deg"] = self._camera.field_of_view_deg
        return self._observed(), info | self._tours_now(self._told)

    def step(self, action: SupportsInt) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Act. At the end of a run the information has `is_success`, `spl`, `outcome`, `actions` and `path_length_m`.

        ResetNeeded before a reset and after the end; InvalidAction for no action.
        """
        if self._env is None or self._attempt is None:
            raise ResetNeeded("no run is under way; call reset")
        if not 0 <= int(action) < len(ACTIONS):
            raise InvalidAction(f"{action!r} is no action; the actions are 0 to {len(ACTIONS) - 1}")
        env, self._env = self._env, None  # a run that fails is over
        seen, done = env.step(ACTIONS[int(action)])
        if done:
            self._run = env.score(self._attempt.arm.name, self._attempt.seed)
            spent = self._run.outcome == "budget"
            told = {"is_success": self._run.success, "spl": self._run.spl, "outcome": self._run.outcome}
            told |= {"actions": self._run.actions, "path_length_m": self._run.path_length_m}
            return self._observed(), float(self._run.success), not spent, spent, told
        self._see(seen)
        self._env = env
        return self._observed(), 0.0, False, False, {}

    def render(self) -> np.ndarray | None:
        """The picture where the agent stands, (H, W, 3) uint8, in the mode "rgb_array"."""
        if self.render_mode is None or self._attempt is None or self._seen.rgb is None:
            return None
        return self._seen.rgb.copy()

    def close(self) -> None:
        """Stop the simulator."""
        self._end()
        if self._session is not None:
            self._session.__exit__(None, None, None)
            self._session = None

    @cached_property
    def _looking(self) -> Looking:
        return Looking(self._release.settings)

    def _attempted(self, episode: Episode, seed: int) -> Run:
        if self._session is None or self._session.scene != episode.scene:
            self.close()
            self._session = open_session(episode, self._stage.arm, self._stage)
        places = self._tours.places(self._session, episode)
        lens = episode.protocol.camera.field_of_view_deg
        store = ObservationStore(self._stage.arm, self._stage, lens, Path(episode.scene), elsewhere=places)
        return Run(episode, self._stage.arm, seed, self._stage, store)

    def _begin(self) -> None:
        assert self._attempt is not None, "reset makes it"
        self._run = None
        env = open_env(self._live_session, self._attempt)
        env.looks, self._reachable, self._env = self._looks, env.reachable, env
        self._see(env.observe())

    @property
    def _live_session(self) -> Session:
        assert self._session is not None, "reset makes it"
        return self._session

    def _tour(self, visit: Visit) -> Mapping[str, np.ndarray]:
        """A visit, encoded; read from its files where it is none of the last ones."""
        content = str(visit.content)
        if content not in self._kept:
            self._kept[content] = encoded_tour(visit)
        self._kept.move_to_end(content)
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return self._kept[content]

    def _see(self, seen: Observation) -> None:
        self._seen = seen
        if seen.reachable is not None:
            self._reachable = seen.reachable

    def _observed(self) -> dict[str, Any]:
        """What is seen, in memory of its own."""
        assert self._attempt is not None, "reset makes it"
        return encoded(self._seen, self._reachable, self._attempt.episode.query) | self._tours_now(not self._told)

    def _tours_now(self, here: bool) -> dict[str, np.ndarray]:
        # The caller may change an observation that it keeps.
        return {key: array.copy() for key, array in self._given.items()} if here else {}

    def _end(self) -> None:
        self._env = None
