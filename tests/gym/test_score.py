"""What is driven in the environment is what `ovman eval` drives, run by run and action by action."""

from __future__ import annotations

import gymnasium

import ovman.gym
from ovman.agents.interface import LETTERS
from ovman.gym.spaces import ACTIONS
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.records.task import Relation
from tests.entry.evaluations import DEPTH, command
from tests.episodes import DATA

EVERYDAY = Episode.load(DATA / "episodes" / "everyday.jsonl")


def test_the_actions_of_an_evaluation_come_to_its_run(tmp_path, tours):
    """Where the answer moves and sensors err. The control takes no pictures, and here they are drawn."""
    episode = next(one for one in EVERYDAY if one.relation is Relation.MOVING and one.tours.second.sensors is not None)
    file, out = tmp_path / "one.jsonl", tmp_path / "out"
    file.write_text(episode.to_line())
    assert command("eval", "--out", out, "--cache", tours, "--episodes", file, "--arm", DEPTH, "--seeds", "1") == 0
    (wanted,) = Score.read(out / "runs.jsonl")
    letters = [LETTERS[action] for action in ACTIONS]
    with gymnasium.make(ovman.gym.ID, episodes=file, cache=tours, name=DEPTH, tours="reset") as env:
        env.reset(seed=1)
        *before, last = [env.step(letters.index(letter)) for letter in wanted.trace]
        assert not any(over or spent for _, _, over, spent, _ in before) and (last[2] or last[3])
        assert env.unwrapped.run == wanted and wanted.actions > 0
