"""A job of several scenes writes what a job of each scene writes, on one simulator, and goes on where it was killed."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.evaluation import rollouts
from ovman.records.record import lines
from ovman.settings import MAIN
from ovman.sim import controller
from ovman.workflow.batches import batches
from ovman.workflow.parameter import stage_settings
from tests.arms import CONFIG
from tests.episodes import SIGHTINGS, of_scene

SCENES = ("FloorPlan318", "FloorPlan7", "FloorPlan227")
SEEDS = (0, 1)
NAMES = st.lists(st.sampled_from([f"FloorPlan{number}" for number in range(1, 31)]), unique=True, max_size=20)


@given(st.dictionaries(st.sampled_from(["main", "multi", "everyday", "dev"]), NAMES), st.integers(1, 25))
def test_the_batches_of_a_split_part_its_scenes_in_their_order(scenes, size):
    found = batches(scenes, size)
    assert [batch.number for batch in found] == list(range(1, len(found) + 1))
    assert len({batch.scenes for batch in found}) == len(found)
    for split, names in scenes.items():
        own = [batch for batch in found if split in batch.splits]
        driven = [scene for batch in own for scene in batch.scenes]
        assert all(1 < len(batch.scenes) <= size for batch in own) and len({batch.name for batch in own}) == len(own)
        rest = [scene for scene in names if scene not in driven]
        assert sorted(driven + rest) == sorted(names) and len(rest) == (len(names) if size == 1 else len(names) % size == 1)


def test_splits_with_the_same_scenes_share_their_batches():
    names = {name: split.scenes for name, split in CONFIG.splits.items()}
    found = batches(names, CONFIG.evaluation.scenes_per_job)
    assert {len(batch.scenes) for batch in found} == {CONFIG.evaluation.scenes_per_job}
    assert {batch.splits for batch in found} == {(MAIN, "multi", "everyday"), ("dev", "dev_everyday")}


class Drive:
    """Jobs of an arm on the first episodes of some scenes, in a folder of their own."""

    def __init__(self, folder: Path, arm: str) -> None:
        self.folder, self.settings = folder, stage_settings(CONFIG, "rollouts", arm)
        self.episodes = folder / "episodes.jsonl"
        folder.mkdir()
        self.episodes.write_text(lines(episode for scene in SCENES for episode in of_scene(scene)[:2]), encoding="utf-8")

    def job(self, scenes: Sequence[str]) -> None:
        outputs = {scene: {seed: self.folder / f"{scene}.{seed}.jsonl" for seed in SEEDS} for scene in scenes}
        journals = {scene: self.folder / "journal" / f"{scene}.jsonl" for scene in scenes}
        rollouts.run(self.settings.arm, self.episodes, self.settings, outputs, journals, SIGHTINGS)

    def made(self) -> dict[str, bytes]:
        """The outputs and the journals."""
        return {str(path.relative_to(self.folder)): path.read_bytes() for path in self.folder.rglob("*.jsonl")}


@pytest.fixture
def started(monkeypatch) -> list[str]:
    """The scenes on which simulators were started."""
    scenes: list[str] = []
    start = controller.start
    monkeypatch.setattr(controller, "start", lambda *how: scenes.append(how[1]) or start(*how))
    return scenes


def test_a_job_of_several_scenes_writes_what_a_job_of_each_writes(tmp_path, started):
    together, apart = Drive(tmp_path / "together", "oracle_check"), Drive(tmp_path / "apart", "oracle_check")
    together.job(SCENES)
    assert started == [SCENES[0]]
    for scene in reversed(SCENES):
        apart.job([scene])
    assert len(started) == 1 + len(SCENES)
    assert together.made() == apart.made() and len(apart.made()) == 1 + len(SCENES) * (1 + len(SEEDS))


@pytest.mark.soak
def test_a_job_that_was_killed_goes_on_and_another_size_of_batches_loses_nothing(tmp_path, monkeypatch):
    drive, whole = Drive(tmp_path / "killed", "oracle_check"), Drive(tmp_path / "whole", "oracle_check")
    whole.job(SCENES)
    run, runs, allowed = rollouts.run_episode, [], 5  # in the second scene

    def counted(session, episode, *rest, **offered):
        if len(runs) == allowed:
            raise RuntimeError("killed")
        runs.append(episode.id)
        return run(session, episode, *rest, **offered)

    monkeypatch.setattr(rollouts, "run_episode", counted)
    with pytest.raises(RuntimeError, match="killed"):
        drive.job(SCENES)
    assert [*drive.folder.glob("FloorPlan*")] == []
    allowed = len(SCENES) * 2 * len(SEEDS)
    for scenes in (SCENES[:2], SCENES[2:]):
        drive.job(scenes)
    assert len(runs) == allowed and {runs.count(name) for name in runs} == {len(SEEDS)}, "each once under each seed"
    assert drive.made() == whole.made()
    drive.job(SCENES)
    assert drive.made() == whole.made()
