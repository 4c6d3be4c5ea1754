"""The environment "OVMAN-v1": one run of one episode from reset to end, as `ovman eval` makes it."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import cache, partial
from pathlib import Path
from typing import Any, SupportsInt

import gymnasium
import numpy as np
from gymnasium.error import InvalidAction, ResetNeeded

from ovman.agents.interface import VISITS, Observation, Query, Visit
from ovman.entry import CONFIG, DATA, EntryError
from ovman.entry.entrant import add_arm, ask_in, check_arm
from ovman.entry.evaluation import select_episodes
from ovman.entry.release import Release
from ovman.env import Env
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.tours import TourCache
from ovman.gym.spaces import ACTIONS, CATEGORIES, action_space, encode_observation, encode_tour, observation_space
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.runner import Run, open_env, open_session
from ovman.settings import MAIN, Settings, Source
from ovman.settings.arms import ArmJob, Track
from ovman.settings.config import load
from ovman.settings.settings import arm_job, settings_of_arm
from ovman.shipped import user_cache
from ovman.sim.session import Session

TOURS = ("observation", "reset")
"""Where the tours are: in every observation, or in the information of `reset` alone."""
SEEDS = 2**31
"""Seeds of runs that are drawn are below it."""
KEPT = 2
"""Visits that are kept, of 15 MB each: episodes of a scene have the first in common, seeds of an episode have both."""
AGENT = "ovman.gym.environment:Environment"
"""Takes the place of an agent's function: the caller that steps the environment is the agent."""


class Environment(gymnasium.Env[dict[str, Any], np.int64]):
    """Embodied runs on released episodes.

    A reset with a seed is the run under that seed, as `ovman eval --seeds` makes it, and seeds the generator that episodes and
    seeds of later resets are drawn from. `ovman.gym.spaces` describes actions and observations. The reward is 1.0 at a stop that
    succeeds (Eq. 4) and 0.0 otherwise. A run is terminated by a stop, by an abstention, and by moving nowhere for too long, and
    truncated by its budget. Nothing is rendered after its end: the last observation is the one before the last action.
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
        track: str = Track.PAPER,
    ) -> None:
        """Prepare the environment. It starts no simulator before its first reset, and has one at a time.

        Args:
            split: Of the release; `main` if neither it nor `episodes` is named.
            episodes: A file of episodes.
            scenes: Only episodes of these scenes.
            name: The draws of movers and sensors follow from it, besides episode and seed: the agent's name in its records
                (`ovman eval --name`), or an arm of config.yaml that runs from its tours, whose budget counts as well.
            looks: Whether observations have pictures. Nothing is rendered if not.
            tours: In every "observation", or, as they are constant, in the information of "reset" alone.
            cache: As of `ovman eval`.
            release: As of `ovman eval`.
            config: As of `ovman eval`.
            render_mode: "rgb_array" or None.
            track: "paper", or "words", without category and relation.

        Raises:
            ValueError: One of these does not exist; one line.
        """
        if tours not in TOURS:
            raise ValueError(f"tours: {tours!r} is no place of them; write one of {', '.join(TOURS)}")
        if render_mode is not None and (render_mode not in self.metadata["render_modes"] or not looks):
            raise ValueError(f"render_mode: {render_mode!r} cannot be rendered; write rgb_array, and looks=True")
        if split is not None and episodes is not None:
            raise ValueError("split and episodes exclude each other; write one of them")
        settings, self._arm, self._settings = load_terms(Path(config or CONFIG), name, track)
        if split is None and episodes is None:
            split = MAIN
        of_file = None if episodes is None else Path(episodes)
        chosen = load_episodes(Release(Path(release or DATA), settings), split, of_file, scenes)
        self._episodes, self._waiting = {episode.id: episode for episode in chosen}, list[str]()
        self._looks, self._has_tours = looks, tours == "observation"
        self._tours = TourCache(user_cache() if cache is None else Path(cache).absolute(), logging.getLogger(__name__).info)
        self.render_mode = render_mode
        self.action_space = action_space()
        both = [tour for one in chosen for tour in (one.tours.first, one.tours.second)]
        self._views = max(len(tour.waypoints) * tour.headings for tour in both)
        self.observation_space = observation_space(chosen[0].protocol.camera, looks, self._views if self._has_tours else 0, track)
        self._session: Session | None = None
        self._env: Env | None = None
        self._begun: Run | None = None
        self._kept: dict[str | None, Mapping[str, np.ndarray]] = {}
        self.run: Score | None = None
        """The score of the run that has ended, as a line of `runs.jsonl`; None until then."""

    @property
    def episode_ids(self) -> tuple[str, ...]:
        """Ids of all its episodes, in the order of their file; a reset may name one. They hold scene and relation."""
        return tuple(self._episodes)

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[dict[str, Any], dict[str, Any]]:
        """Begin a run: of the episode {"episode": id}, or of the next one in passes that are drawn.

        Its seed is drawn if none is given. Information: `episode`, its id; `scene`; `seed`; `sentence` and `phrase`, and in the
        paper's track `category` and `relation`; `field_of_view_deg`, vertical; and the tours under the keys that they otherwise
        have in an observation.

        Raises:
            ValueError: Other options.
            SimulatorError, SimulatorDied: In one line.
        """
        super().reset(seed=seed)
        episode = self._choose(options or {}, is_first=seed is not None)
        self._env = self.run = None
        session = self._session_on(episode)
        places, lens = self._tours.places(session, episode), episode.protocol.camera.field_of_view_deg
        store = ObservationStore(self._arm, self._settings, lens, Path(episode.scene), elsewhere=places)
        run_seed = int(self.np_random.integers(SEEDS)) if seed is None else seed
        run = self._begun = Run(episode, self._arm, run_seed, self._settings, store)
        # A simulator that dies until the first observation is replaced; later its run cannot go on.
        self._env, seen = session.with_restarts(partial(self._begin, session, run))
        self._reachable = self._env.reachable
        self._see(seen)
        visits = run.tour("first", self._env.reachable_first), run.tour("second", self._reachable)
        shown = zip(VISITS, map(self._encode, visits), strict=True)
        self._shown = {f"{which}_{part}": array for which, tour in shown for part, array in tour.items()}
        info = {"episode": episode.id, "scene": episode.scene, "seed": run_seed}
        info |= {"sentence": run.asked.sentence, "phrase": run.asked.phrase, "field_of_view_deg": lens}
        if isinstance(run.asked, Query):
            info |= {"category": run.asked.category, "relation": str(run.asked.relation)}
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
            raise InvalidAction(f"{action!r} is not an action; the actions are 0 to {len(ACTIONS) - 1}")
        env, self._env = self._env, None  # a run that fails is over
        seen, done = env.step(ACTIONS[int(action)])
        if not done:
            self._env = env
            self._see(seen)
            return self._observed(), 0.0, False, False, {}
        score = self.run = env.score(self._arm.name, self._begun.seed)
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

    def _choose(self, options: Mapping[str, Any], is_first: bool) -> Episode:
        """Return the named episode, or the next of a pass: each comes once before any comes again. is_first: Of a new pass."""
        if unknown := sorted(set(options) - {"episode"}):
            raise ValueError(f"options: {unknown[0]} is not an option; write episode")
        if is_first:
            self._waiting = []
        if "episode" in options:
            if options["episode"] not in self._episodes:
                raise ValueError(f"options: episode: {options['episode']!r} is not among the environment's; see episode_ids")
            return self._episodes[options["episode"]]
        if not self._waiting:
            self._waiting = [self.episode_ids[k] for k in self.np_random.permutation(len(self._episodes))]
        return self._episodes[self._waiting.pop(0)]

    def _session_on(self, episode: Episode) -> Session:
        if self._session is None or self._session.scene != episode.scene:
            self.close()
            self._session = open_session(episode, self._arm, self._settings)
        return self._session

    def _begin(self, session: Session, run: Run) -> tuple[Env, Observation]:
        env = open_env(session, run)
        env.looks = self._looks
        return env, env.observe()

    def _encode(self, visit: Visit) -> Mapping[str, np.ndarray]:
        """Return a visit encoded; read it from its files unless it is one of the last."""
        content = visit.content
        if content not in self._kept:
            if len(self._kept) >= KEPT:
                del self._kept[next(iter(self._kept))]
            self._kept[content] = encode_tour(visit, self._views)
        return self._kept[content]

    def _see(self, seen: Observation) -> None:
        self._seen = seen
        if seen.reachable is not None:
            self._reachable = seen.reachable

    def _observed(self) -> dict[str, Any]:
        """Return the observation, in memory of its own."""
        assert self._begun is not None, "reset makes it"
        seen = encode_observation(self._seen, self._reachable, self._begun.asked)
        return seen | self._copied_tours() if self._has_tours else seen

    def _copied_tours(self) -> dict[str, np.ndarray]:
        return {key: array.copy() for key, array in self._shown.items()}  # the caller may change what it keeps


@cache
def load_terms(config: Path, name: str, track: str) -> tuple[Settings, ArmJob, Settings]:
    """Return the settings of a file, an arm that it has or a new one of that name, and the settings of the arm's job.

    EntryError, in one line, for an arm that needs more than the tours and what is computed from them, for an invalid name, and
    for a track that there is not or that the arm cannot be asked in.
    """
    settings = load(config)
    try:
        if name in settings.arms:
            check_arm(settings, name, None, None)
        else:
            settings, _ = add_arm(settings, AGENT, name, None)
    except EntryError as error:
        raise EntryError(f"name: {str(error).partition(': ')[2]}") from None
    try:
        settings = ask_in(settings, name, track)
    except EntryError as error:
        raise EntryError(f"track: {str(error).partition(': ')[2]}") from None
    arm = settings.arms[name]
    if Source.HANDED in (arm.answer, arm.positions) or arm.embodiment != "default":
        raise EntryError(f"name: {name} is an arm that is given other things than the tours; write another name")
    return settings, arm_job(settings, name), settings_of_arm(settings, name)


def load_episodes(release: Release, split: str | None, episodes: Path | None, scenes: Sequence[str]) -> Sequence[Episode]:
    """Return the episodes of a split or of a file, only those of some scenes if scenes are named; all have one camera.

    EntryError or RecordError, in one line.
    """
    try:
        chosen = select_episodes(release, split, episodes, scenes, ()).chosen
    except EntryError as error:
        raise EntryError(str(error).removeprefix("--")) from None
    if unknown := [episode for episode in chosen if episode.category not in CATEGORIES]:
        raise EntryError(f"{unknown[0].id}: {unknown[0].category} is not a category of the vocabulary; name other episodes")
    if len(cameras := {one.protocol.camera for one in chosen}) > 1:
        raise EntryError(f"the episodes have {len(cameras)} cameras, and an environment has one; name others")
    return chosen
