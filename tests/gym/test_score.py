"""The Gymnasium environment and the benchmark make the same runs, action by action."""

from __future__ import annotations

import gymnasium

import ovman.gym
from ovman.agents.interface import LETTERS
from ovman.gym.spaces import ACTIONS
from ovman.records.run import Score
from tests.entry.evaluations import DEPTH, moving_everyday
from tests.episodes import DATA


def test_the_actions_of_a_released_run_come_to_it(tmp_path, tours):
    """Where the answer moves and sensors err. The control takes no pictures, and here they are drawn."""
    episode, file = moving_everyday(), tmp_path / "one.jsonl"
    file.write_text(episode.to_line())
    released = Score.read(DATA / "scores" / "everyday" / f"{DEPTH}.jsonl")
    (wanted,) = (run for run in released if run.episode == episode.id and run.seed == 1)
    letters = [LETTERS[action] for action in ACTIONS]
    with gymnasium.make(ovman.gym.ID, episodes=file, cache=tours, name=DEPTH, tours="reset") as env:
        env.reset(seed=1)
        *before, last = [env.step(letters.index(letter)) for letter in wanted.trace]
        assert not any(over or spent for _, _, over, spent, _ in before) and (last[2] or last[3])
        assert env.unwrapped.run == wanted and wanted.actions > 0
