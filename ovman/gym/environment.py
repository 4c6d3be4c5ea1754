"""The environment "OVMAN-v1": one run of one episode from reset to end, as `ovman eval` makes it."""

from __future__ import annotations

import logging
from collections import OrderedDict
from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from pathlib import Path
from typing import Any, SupportsInt

import gymnasium
import numpy as np
from gymnasium.error import InvalidAction, ResetNeeded

from ovman.agents.interface import VISITS, Observation, Visit
from ovman.analysis.outcomes import Case, embodied_outcomes
from ovman.analysis.rates import arm_rates
from ovman.entry import CONFIG, DATA
from ovman.entry.release import Release, compare_with_baselines
from ovman.entry.tables import rate_rows, table
from ovman.env import Env
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.tours import TourCache
from ovman.gym.encoding import encode_observation, encode_tour
from ovman.gym.episodes import Order, count_views, load_episodes, load_terms
from ovman.gym.spaces import ACTIONS, action_space, observation_space
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.remote.host import HostedContext
from ovman.remote.perception import PerceptionPipeline
from ovman.runner import Run, open_env, open_session
from ovman.settings import MAIN, Kind
from ovman.settings.arms import ArmJob
from ovman.shipped import user_cache
from ovman.sim.session import Session

TOURS = ("observation", "reset")
"""Where the tours are: in every observation, or in the information of `reset` alone."""
SEEDS = 2**31
"""Seeds of runs that are drawn are below it."""
KEPT = 2
"""Visits that are kept, of 15 MB each: episodes of a scene have the first in common, seeds of an episode have both."""


class Environment(gymnasium.Env[dict[str, Any], np.int64]):
    """Embodied runs on released episodes.

    A reset with a seed is the run under that seed, as `ovman eval --seeds` makes it, and seeds the generator that episodes and
    seeds of later resets are drawn from. An action is a number in `ovman.gym.spaces.ACTIONS`; `ovman.gym.encoding` describes the
    observations. The reward is 1.0 at a stop that succeeds (Eq. 4) and 0.0 otherwise. A run is terminated by a stop, by an
    abstention, and by moving nowhere for too long, and truncated by its budget. Nothing is rendered after its end: the last
    observation is the one before the last action.
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
        """Prepare the environment. It starts no simulator before its first reset, and has one at a time.

        Args:
            split: Of the release; `main` if neither it nor `episodes` is named.
            episodes: A file of episodes.
            scenes: Only episodes of these floor plans.
            name: The draws of movers and sensors follow from it, besides episode and seed: the agent's name in its records
                (`ovman eval --name`), or an arm of config.yaml that runs from its tours, whose budget counts as well.
            looks: Whether observations have pictures. Nothing is rendered if not.
            tours: In every "observation", or, as they are constant, in the information of "reset" alone.
            cache: As of `ovman eval`.
            release: As of `ovman eval`.
            config: As of `ovman eval`.
            render_mode: "rgb_array" or None.

        Raises:
            ValueError: One of these does not exist; one line.
        """
        if tours not in TOURS:
            raise ValueError(f"tours: {tours!r} is no place of them; write one of {', '.join(TOURS)}")
        if render_mode is not None and (render_mode not in self.metadata["render_modes"] or not looks):
            raise ValueError(f"render_mode: {render_mode!r} cannot be rendered; write rgb_array, and looks=True")
        if split is not None and episodes is not None:
            raise ValueError("split and episodes exclude each other; write one of them")
        settings, self._arm, self._settings = load_terms(Path(config or CONFIG), name)
        self._release = Release(Path(release or DATA), settings)
        if split is None and episodes is None:
            split = MAIN
        chosen = load_episodes(self._release, split, None if episodes is None else Path(episodes), scenes)
        self._order, self._camera = Order(chosen), chosen[0].protocol.camera
        self._looks, self._has_tours = looks, tours == "observation"
        self._tours = TourCache(user_cache() if cache is None else Path(cache).absolute(), logging.getLogger(__name__).info)
        self.render_mode = render_mode
        self.action_space = action_space()
        self.observation_space = observation_space(self._camera, count_views(chosen[0]), looks, self._has_tours)
        self._session: Session | None = None
        self._env: Env | None = None
        self._begun: Run | None = None
        self._score: Score | None = None
        self._kept: OrderedDict[str, Mapping[str, np.ndarray]] = OrderedDict()
        self._shown: Mapping[str, np.ndarray] = {}

    @property
    def episode_ids(self) -> tuple[str, ...]:
        """Ids of all its episodes, in the order of their file; a reset may name one. They hold scene and relation."""
        return self._order.ids

    @property
    def run(self) -> Score | None:
        """The score of the run that has ended, as a line of `runs.jsonl`; None until then."""
        return self._score

    @property
    def arm(self) -> ArmJob:
        """The arm that its runs are of: name, needs, budget."""
        return self._arm

    def rates(self, runs: Sequence[Score]) -> str:
        """Return the table of runs by relation that `ovman eval` prints. ValueError unless each seed has every episode once."""
        asked = [self._order.by_id[name] for name in dict.fromkeys(run.episode for run in runs)]
        outcomes = embodied_outcomes([Case.of(episode) for episode in asked], runs)
        rates = arm_rates(outcomes, self._release.settings.evaluation.confidence)
        chance = compare_with_baselines(outcomes, Kind.EMBODIED, None, self._release).chance
        return "\n".join(table(rate_rows(rates, chance), markdown=False))

    def context(self) -> HostedContext:
        """Return an `AgentContext` for the present run, for an agent of `ovman.agents.interface`.

        Besides draws and constants, everything in it is computed from the visits that are put into it. ResetNeeded before the
        first reset.
        """
        if self._begun is None:
            raise ResetNeeded("no run has begun; call reset")
        own = self._begun.context()
        return HostedContext(own.rng, own.settings, own.pilot, self._perception, frozenset(self._arm.needs), self._arm.name)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin a run: of the next episode, of the episode {"episode": id}, or of a drawn one of {"scene": name}.

        Its seed is drawn if none is given. Information: `episode`, its id; `scene`; `seed`; `category` and `relation`, the query
        in words; `field_of_view_deg`, vertical; and the tours under the keys that they otherwise have in an observation.

        Raises:
            ValueError: Other options.
            SimulatorError, SimulatorDied: In one line.
        """
        super().reset(seed=seed)
        if seed is not None:
            self._order.restart()
        episode = self._order.next(options or {}, self.np_random)
        self._env = self._score = None
        session = self._session_on(episode)
        self._begun = self._run_of(episode, int(self.np_random.integers(SEEDS)) if seed is None else seed, session)
        # A simulator that dies until the first observation is replaced; later its run cannot go on.
        env, seen = session.with_restarts(partial(self._begin, session, self._begun))
        self._env, self._reachable = env, env.reachable
        self._see(seen)
        visits = self._begun.tour("first", np.empty((0, 2))), self._begun.tour("second", self._reachable)
        shown = zip(VISITS, map(self._tour, visits), strict=True)
        self._shown = {f"{which}_{part}": array for which, tour in shown for part, array in tour.items()}
        info = {"episode": episode.id, "scene": episode.scene, "seed": self._begun.seed}
        info |= {"category": episode.category, "relation": str(episode.relation)}
        info["field_of_view_deg"] = self._camera.field_of_view_deg
        return self._observed(), info if self._has_tours else info | self._copied_tours()

    def step(self, action: SupportsInt) -> tuple[dict[str, Any], float, bool, bool, dict[str, Any]]:
        """Act. At the end of a run the information has `is_success`, `spl`, `outcome`, `actions` and `path_length_m`.

        Raises:
            ResetNeeded: Before a reset, and after the end of a run.
            InvalidAction: The number is not an action.
        """
        if self._env is None or self._begun is None:
            raise ResetNeeded("no run is under way; call reset")
        if not 0 <= int(action) < len(ACTIONS):
            raise InvalidAction(f"{action!r} is no action; the actions are 0 to {len(ACTIONS) - 1}")
        env, self._env = self._env, None  # a run that fails is over
        seen, done = env.step(ACTIONS[int(action)])
        if not done:
            self._env = env
            self._see(seen)
            return self._observed(), 0.0, False, False, {}
        score = self._score = env.score(self._arm.name, self._begun.seed)
        is_spent = score.outcome == "budget"
        info = {"is_success": score.success, "spl": score.spl, "outcome": score.outcome}
        info |= {"actions": score.actions, "path_length_m": score.path_length_m}
        return self._observed(), float(score.success), not is_spent, is_spent, info

    def render(self) -> np.ndarray | None:
        """Return the picture at the agent's pose, (H, W, 3) uint8, in the mode "rgb_array"."""
        if self.render_mode is None or self._begun is None or self._seen.rgb is None:
            return None
        return self._seen.rgb.copy()

    def close(self) -> None:
        """Stop the simulator."""
        self._env = None
        if self._session is not None:
            self._session.__exit__(None, None, None)
            self._session = None

    @cached_property
    def _perception(self) -> PerceptionPipeline:
        return PerceptionPipeline(self._release.settings)

    def _session_on(self, episode: Episode) -> Session:
        if self._session is None or self._session.scene != episode.scene:
            self.close()
            self._session = open_session(episode, self._arm, self._settings)
        return self._session

    def _run_of(self, episode: Episode, seed: int, session: Session) -> Run:
        lens, places = episode.protocol.camera.field_of_view_deg, self._tours.places(session, episode)
        store = ObservationStore(self._arm, self._settings, lens, Path(episode.scene), elsewhere=places)
        return Run(episode, self._arm, seed, self._settings, store)

    def _begin(self, session: Session, run: Run) -> tuple[Env, Observation]:
        env = open_env(session, run)
        env.looks = self._looks
        return env, env.observe()

    def _tour(self, visit: Visit) -> Mapping[str, np.ndarray]:
        """Return a visit encoded; read it from its files unless it is one of the last."""
        content = str(visit.content)
        if content not in self._kept:
            self._kept[content] = encode_tour(visit)
        self._kept.move_to_end(content)
        while len(self._kept) > KEPT:
            self._kept.popitem(last=False)
        return self._kept[content]

    def _see(self, seen: Observation) -> None:
        self._seen = seen
        if seen.reachable is not None:
            self._reachable = seen.reachable

    def _observed(self) -> dict[str, Any]:
        """Return the observation, in memory of its own."""
        assert self._begun is not None, "reset makes it"
        seen = encode_observation(self._seen, self._reachable, self._begun.episode.query)
        return seen | self._copied_tours() if self._has_tours else seen

    def _copied_tours(self) -> dict[str, np.ndarray]:
        return {key: array.copy() for key, array in self._shown.items()}  # the caller may change what it keeps
