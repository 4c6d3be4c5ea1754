"""Evaluations for tests: a folder each, made by the command."""

from __future__ import annotations

from ovman.cli import main
from ovman.records.episode import Episode
from ovman.records.task import Relation
from tests.arms import CONFIG
from tests.episodes import DATA, of_scene

SCENE = "FloorPlan10"
"""Few episodes of main, none of which moves."""
ASKED = len(of_scene(SCENE))
SECOND_SCENE = "FloorPlan429"
"""More episodes of main, none of which moves."""
ORACLE = next(name for name, arm in CONFIG.arms.items() if arm.answer == "handed")
DEPTH = next(name for name, entry in CONFIG.comparisons.controls.items() if entry.role == "depth_driving")

WANDERER = """
from ovman.agents.interface import Action
WAYS = [Action.MOVE_AHEAD] * 4 + [Action.ROTATE_LEFT, Action.ROTATE_RIGHT]

class Wanderer:
    def __init__(self, context): self.rng, self.left = context.rng, 24
    familiarise = revisit = lambda self, visit: None
    def ask(self, query): self.stops = query.relation != "former"
    def act(self, observation):
        assert observation.rgb is not None
        self.left -= 1
        last = Action.STOP if self.stops else Action.ABSTAIN
        return WAYS[self.rng.integers(len(WAYS))] if self.left else last
"""
"""An agent that draws, takes pictures, and ends in each way."""


def command(*options):
    """The exit status of `ovman` with these options."""
    return main([str(option) for option in options])


def contents(directory):
    """The files of an evaluation by their paths, without its lock."""
    files = (path for path in directory.rglob("*") if path.is_file() and path.name != ".lock")
    return {str(path.relative_to(directory)): path.read_bytes() for path in files}


def moving():
    """A released episode in which the answer moves."""
    return next(episode for episode in of_scene("FloorPlan7") if episode.relation is Relation.MOVING)


def moving_everyday():
    """A released episode with another second tour and sensors that err, in which the answer moves."""
    everyday = Episode.load(DATA / "episodes" / "everyday.jsonl")
    return next(one for one in everyday if one.relation is Relation.MOVING and one.tours.second.sensors is not None)


def lines(path):
    """The lines of a file."""
    return path.read_text(encoding="utf-8").splitlines()
