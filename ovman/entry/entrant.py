"""The agent that enters: an arm of config.yaml, or an arm made for an agent of the user's."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

from pydantic import ValidationError

from ovman.entry import EntryError
from ovman.settings import Arm, Kind, Need, Settings, Source
from ovman.settings.arms import Track

MADE_APART = frozenset({Need.TOURS, Need.MAPS, Need.DETECTIONS, Need.SEGMENTS, Need.NETWORKS})
"""Inputs that an agent in a process of its own can be given: frames come to it, and the rest is computed from them there."""
SERVED = "ovman.remote.agent:RemoteAgent"
"""Takes the place of the agent's own function if a server has it."""


def select_arm(
    settings: Settings,
    agent: str | None,
    arm: str | None,
    name: str | None,
    needs: Sequence[str] | None,
    track: str | None = None,
) -> tuple[Settings, str]:
    """Return the settings with the arm that is evaluated, and its name; a server's if neither an agent nor an arm is named.

    track: Of the arm; that of its entry, or the paper's, if None.
    """
    if arm is not None:
        name = check_arm(settings, arm, name, needs)
    elif agent is None and name is None:
        raise EntryError("--server: say what its agent is called in the records, with --name; or which --arm it serves")
    else:
        settings, name = add_arm(settings, agent or SERVED, name, needs)
    return settings if track is None else ask_in(settings, name, track), name


def ask_in(settings: Settings, name: str, track: str) -> Settings:
    """Return the settings with an arm that is asked in a track. EntryError for an unknown track or an arm that is told more."""
    if track not in [*Track]:
        raise EntryError(f"--track: {track!r} is not a track; write one of {', '.join(Track)}")
    arm = settings.arms[name]
    if track == Track.WORDS and Source.HANDED in (arm.grounding, arm.positions, arm.answer):
        raise EntryError(f"--track: {name} is told what a sentence means; name an arm that is not, or leave --track out")
    return settings.model_copy(update={"arms": {**settings.arms, name: arm.model_copy(update={"track": Track(track)})}})


def add_arm(settings: Settings, agent: str, name: str | None, needs: Sequence[str] | None) -> tuple[Settings, str]:
    """Return the settings with an arm for an agent of the user's, and the arm's name.

    Raises:
        EntryError: The name is taken or invalid, or the agent needs something that is not made outside the workflow.
    """
    file, _, attribute = agent.partition(":")
    if file.endswith(".py"):
        raise EntryError(f"--agent: {file} is a file; write {Path(file).stem}:{attribute or 'Agent'}")
    wanted = [str(Need.TOURS)] if needs is None else list(needs)
    if others := [need for need in wanted if need not in set(map(str, MADE_APART))]:
        able = ", ".join(sorted(MADE_APART))
        raise EntryError(f"--needs: {others[0]} is not made outside the workflow; write some of {able}, or an arm in an overlay")
    name = re.sub(r"\W", "_", agent.partition(":")[0].rpartition(".")[2].lower()) if name is None else name
    if name in settings.arms:
        raise EntryError(f"--name: {name} is an arm of config.yaml; write another name")
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
        raise EntryError(f"--name: {name!r} cannot name an arm; write small letters, digits and _")
    try:
        entry = {"name": name, "kind": "embodied", "agent": agent, "system": name, "memory": "its own", "needs": wanted}
        arm = Arm.model_validate(entry)
    except ValidationError as error:
        said = error.errors()[0]["msg"].removeprefix("Value error, ")
        raise EntryError(f"--agent: {said}") from None
    return settings.model_copy(update={"arms": {**settings.arms, name: arm}}), name


def check_arm(settings: Settings, name: str, called: str | None, needs: Sequence[str] | None) -> str:
    """Return the name of an arm of config.yaml that runs from episodes and tours alone. EntryError for another."""
    if called is not None or needs is not None:
        raise EntryError("--name and --needs are of an --agent or a --server; an arm of config.yaml has its own")
    able = list_arms(settings)
    if name not in able:
        why = "does not drive from episodes and tours alone" if name in settings.arms else "is no arm of config.yaml"
        raise EntryError(f"--arm: {name} {why}; write one of {', '.join(able)}")
    return name


def list_arms(settings: Settings) -> list[str]:
    """Return the names of the arms of config.yaml that run from episodes and tours alone."""
    return [arm.name for arm in settings.arms.values() if _runs_alone(arm)]


def runs_in_process(arm: Arm) -> bool:
    """Return whether an arm can run in the evaluator's process: it is given tours at most."""
    return set(arm.needs) <= {Need.TOURS}


def _runs_alone(arm: Arm) -> bool:
    """Return whether an arm drives by itself and needs nothing that is neither in the episode nor computed from its tours."""
    alone = arm.made_by is None and arm.cut_from is None and not arm.reads_sightings
    return arm.kind is Kind.EMBODIED and alone and set(arm.needs) <= MADE_APART
