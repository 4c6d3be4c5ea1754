"""An agent that does what a trace says, and what it takes to put it in the place of the one that was recorded."""

from __future__ import annotations

from collections.abc import Mapping

from ovman.agents.interface import LETTERS, Action, Observation, Query, Visit
from ovman.entry.manifest import Manifest
from ovman.settings import Arm, Kind, Settings
from ovman.workflow.parameter import StageSettings, stage_settings

ACTIONS: Mapping[str, Action] = {letter: action for action, letter in LETTERS.items()}
"""Actions by the letters of a trace."""
BODIES: Mapping[str, tuple[str, ...]] = {"locobot": ("locobot.*",)}
"""The constants of each body that is not the benchmark's own."""


class Replay:
    """An agent that does what `trace` says, a letter an action, and abstains where a run goes on beyond it.

    Nothing is drawn for it.
    """

    looks = False

    def __init__(self, trace: str) -> None:
        self._left = [ACTIONS[letter] for letter in reversed(trace)]

    def familiarise(self, visit: Visit) -> None:
        """What it does is known."""

    def revisit(self, visit: Visit) -> None:
        """What it does is known."""

    def ask(self, query: Query) -> None:
        """What it does is known."""

    def act(self, observation: Observation) -> Action:
        """The next action of the trace."""
        return self._left.pop() if self._left else Action.ABSTAIN


def replay_settings(settings: Settings, manifest: Manifest) -> StageSettings:
    """The settings of stage `rollouts` for the runs of a manifest, under the name of their arm: draws follow from it.

    The agent of the manifest is neither imported nor looked for, and nothing is handed over: the replay needs its trace alone.
    """
    entry = Arm(
        name=manifest.arm,
        kind=Kind.EMBODIED,
        agent=f"{Replay.__module__}:{Replay.__name__}",
        system=manifest.arm,
        memory="a trace",
        constants=BODIES.get(manifest.embodiment, ()),
        embodiment=manifest.embodiment,
        any_instance=manifest.any_instance,
        budget=manifest.budget,
    )
    cutting = [entry.model_copy(update={"cut_from": entry.name, "budget": mark}) for mark in manifest.marks]
    arms = {entry.name: entry, **{f"{entry.name}_{arm.budget}": arm for arm in cutting}}
    return stage_settings(settings.model_copy(update={"arms": arms}), "rollouts", entry.name)
