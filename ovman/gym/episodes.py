"""The episodes of an environment, the terms of their runs, and their order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from ovman.entry import EntryError
from ovman.entry.entrant import add_arm, check_arm
from ovman.entry.evaluation import select_episodes
from ovman.entry.release import Release
from ovman.gym.spaces import CATEGORIES
from ovman.records.episode import Episode
from ovman.settings import Settings, Source
from ovman.settings.arms import ArmJob
from ovman.settings.config import load
from ovman.settings.jobs import arm_job, settings_of_arm

AGENT = "ovman.gym.environment:Environment"
"""Takes the place of an agent's function: the caller that steps the environment is the agent."""


@cache
def load_terms(config: Path, name: str) -> tuple[Settings, ArmJob, Settings]:
    """Return the settings of a file, an arm that it has or a new one of that name, and the settings of the arm's job.

    EntryError, in one line, for an arm that needs more than the tours and what is computed from them, and for an invalid name.
    """
    settings = load(config)
    try:
        if name in settings.arms:
            check_arm(settings, name, None, None)
        else:
            settings, _ = add_arm(settings, AGENT, name, None)
    except EntryError as error:
        raise EntryError(f"name: {str(error).partition(': ')[2]}") from None
    arm = settings.arms[name]
    if Source.HANDED in (arm.answer, arm.positions) or arm.embodiment != "default":
        raise EntryError(f"name: {name} is an arm that is given other things than the tours; write another name")
    return settings, arm_job(settings, name), settings_of_arm(settings, name)


def load_episodes(release: Release, split: str | None, episodes: Path | None, scenes: Sequence[str]) -> Sequence[Episode]:
    """Return the episodes of a split or of a file, only those of some scenes if scenes are named; all have one camera.

    EntryError or RecordError, in one line.
    """
    try:
        chosen = select_episodes(release, split, episodes, scenes, (1, 1), ()).chosen
    except EntryError as error:
        raise EntryError(str(error).removeprefix("--")) from None
    if unknown := [episode for episode in chosen if episode.category not in CATEGORIES]:
        raise EntryError(f"{unknown[0].id}: {unknown[0].category} is no category of the vocabulary; name other episodes")
    shown = {(episode.protocol.camera, count_views(episode)) for episode in chosen}
    if len(shown) > 1:
        raise EntryError(f"the episodes have {len(shown)} cameras or lengths of tours, and an environment has one; name others")
    return chosen


def count_views(episode: Episode) -> int:
    """Return the number of views of each tour of an episode. EntryError if the tours differ in it."""
    first, second = (len(tour.waypoints) * tour.headings for tour in (episode.tours.first, episode.tours.second))
    if first != second:
        raise EntryError(f"{episode.id}: tours of {first} and {second} views; name other episodes")
    return first


class Order:
    """Episodes in passes: each comes once, in an order that is drawn, before any comes again. by_id: all, in their order."""

    def __init__(self, episodes: Sequence[Episode]) -> None:
        self.by_id = {episode.id: episode for episode in episodes}
        self._waiting: list[str] = []

    @property
    def ids(self) -> tuple[str, ...]:
        """All, in the order of their file."""
        return tuple(self.by_id)

    def restart(self) -> None:
        """Begin a new pass."""
        self._waiting = []

    def next(self, options: Mapping[str, Any], rng: np.random.Generator) -> Episode:
        """Return the episode {"episode": id}, a drawn one of {"scene": name}, or the next of the pass for {}.

        ValueError, in one line, for other options and where there is none.
        """
        if unknown := sorted(set(options) - {"episode", "scene"}):
            raise ValueError(f"options: {unknown[0]} is no option; write episode or scene")
        if len(options) > 1:
            raise ValueError("options: episode and scene exclude each other; write one of them")
        if "episode" in options:
            if options["episode"] not in self.by_id:
                raise ValueError(f"options: episode: {options['episode']!r} is not among the environment's; see episode_ids")
            return self.by_id[options["episode"]]
        if "scene" in options:
            there = [episode for episode in self.by_id.values() if episode.scene == options["scene"]]
            if not there:
                scenes = ", ".join(sorted({episode.scene for episode in self.by_id.values()}))
                raise ValueError(f"options: scene: {options['scene']!r} has no episode here; write one of {scenes}")
            return there[int(rng.integers(len(there)))]
        if not self._waiting:
            self._waiting = [self.ids[k] for k in rng.permutation(len(self.ids))]
        return self.by_id[self._waiting.pop(0)]
