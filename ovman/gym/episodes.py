"""The episodes of an environment, and the terms of their runs."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

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
        chosen = select_episodes(release, split, episodes, scenes, ()).chosen
    except EntryError as error:
        raise EntryError(str(error).removeprefix("--")) from None
    if unknown := [episode for episode in chosen if episode.category not in CATEGORIES]:
        raise EntryError(f"{unknown[0].id}: {unknown[0].category} is no category of the vocabulary; name other episodes")
    tours = [(one.protocol.camera, tour) for one in chosen for tour in (one.tours.first, one.tours.second)]
    if len(shown := {(camera, len(tour.waypoints) * tour.headings) for camera, tour in tours}) > 1:
        raise EntryError(f"the episodes have {len(shown)} cameras or lengths of tours, and an environment has one; name others")
    return chosen
