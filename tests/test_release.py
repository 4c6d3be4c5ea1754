"""The released records are what they say: whole, consistent, re-derivable, and made again to the same bytes."""

from __future__ import annotations

import hashlib
from collections import Counter
from itertools import product
from pathlib import Path

import pandas as pd
import pytest

from ovman.cache import Cache
from ovman.evaluation import predictions, rollouts, scores
from ovman.generation import certification, release, scenes, trials, verdict
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.run import Score
from ovman.records.task import Relation
from ovman.records.trial import Certification, Trial
from ovman.settings import MAIN, Kind, Source, of_kind
from ovman.settings.config import load
from ovman.task import referents
from tests.arms import ARMS
from tests.episodes import DATA, EPISODES, SIGHTINGS
from tests.runs import job

ROOT = Path(__file__).parent.parent
CONFIG = load(ROOT / "config.yaml")
REGENERATED = (
    ("FloorPlan10", {*Relation} - {Relation.MOVING}),
    pytest.param("FloorPlan318", {*Relation}, marks=pytest.mark.soak),
)
"""A small scene, and one that has episodes of every relation: their names, and the relations of their episodes."""


@pytest.fixture(scope="module")
def released_in():
    """The released episodes of every split by their ids."""
    files = [file for file in (DATA / "episodes").glob("*.jsonl") if not file.stem.endswith("sightings")]
    return {file.stem: {episode.id: episode for episode in Episode.load(file)} for file in files}


def test_every_file_has_its_checksum():
    sums = dict(reversed(line.split("  ", 1)) for line in (DATA / "SHA256SUMS").read_text().splitlines())
    files = {p.relative_to(DATA).as_posix() for p in DATA.rglob("*") if p.is_file()} - {"SHA256SUMS"}
    assert set(sums) == files
    for name, checksum in sums.items():
        assert hashlib.sha256((DATA / name).read_bytes()).hexdigest() == checksum, name


def test_the_split_is_the_papers(released_in):
    released = released_in[MAIN].values()
    counts = Counter(e.relation.value for e in released)
    assert counts == {"moved": 33, "former": 38, "moving": 36, "stable": 32, "appeared": 40, "removed": 40}
    assert len({e.scene for e in released}) == 20 == len(CONFIG.splits[MAIN].scenes)


def test_every_episode_was_completed_four_times_and_its_referent_is_unique(released_in):
    assert {*released_in} == {*CONFIG.splits}
    for episode in (episode for episodes in released_in.values() for episode in episodes.values()):
        assert len(episode.certification) == 1 + CONFIG.admissibility.runs
        assert all(run.success for run in episode.certification), episode.id
        assert referents(*episode.states, episode.query, CONFIG) == (episode.target,), episode.id


def test_answers_from_true_positions_follow_from_the_released_records(tmp_path):
    # What the other arms answer follows from maps, which networks make.
    for arm in (arm for arm in of_kind(ARMS, Kind.STATIC) if arm.positions is Source.HANDED and arm.on_main):
        predictions.run(*job(arm.name), EPISODES, tmp_path / f"{arm.name}.jsonl", sightings_file=SIGHTINGS)
        assert (tmp_path / f"{arm.name}.jsonl").read_bytes() == (DATA / "predictions" / "main" / f"{arm.name}.jsonl").read_bytes()


def test_every_agent_has_run_every_episode_of_its_splits_with_every_seed(released_in):
    for name, split in ((name, split) for name, split in CONFIG.splits.items() if split.in_main_job):
        rows = pd.read_csv(DATA / "metrics" / name / "embodied_outcomes.csv")
        found = [*rows[["arm", "seed", "episode"]].itertuples(index=False, name=None)]
        # Arms that main does not have may be newer than the release.
        known = {arm.name for arm in ARMS if arm.on_main} | {*rows["arm"]}
        arms = [arm.name for arm in of_kind(ARMS, Kind.EMBODIED) if arm.name in known & {*split.arms}]
        whole = {*product(arms, CONFIG.evaluation.seeds, released_in[name])}
        assert len(found) == len(whole) and {*found} == whole, name


def test_several_movers_walk_each_on_a_floor_of_its_own(released_in):
    together = [one for one in released_in["everyday"].values() if len(one.movers) > 1]
    assert together
    for one in together:
        walks = [change for change in one.changes if change.kind == "motion"]
        assert {mover.instance for mover in one.movers} == {change.instance for change in walks}
        for change in walks:
            assert {change.roam.cell(point) for point in change.path} <= change.roam.cells
            assert len({*change.path}) > 1 and len(change.path) == len(one.tours.second.poses) + 1


def rows_of(stage: str, scene: str, split: str = MAIN) -> list[str]:
    """Return the released lines of a scene."""
    lines = (DATA / stage / f"{split}.jsonl").read_text().splitlines(keepends=True)
    return [line for line in lines if f'"{scene}/' in line or f'"scene":"{scene}"' in line]


@pytest.mark.parametrize(("scene", "relations"), REGENERATED)
def test_a_scene_is_made_again_to_the_same_bytes(tmp_path, scene, relations):
    cache = Cache(tmp_path / "cache")

    def path(stage: str) -> Path:
        return tmp_path / f"{stage}.jsonl"

    scenes.run([scene], CONFIG, path("scenes"), cache)
    assert path("scenes").read_text() == "".join(rows_of("scenes", scene))
    path("trials").write_text("".join(rows_of("trials", scene)))
    episodes = {episode.id: episode for episode in Episode.load(EPISODES) if episode.scene == scene}
    # Trials do not depend on each other, and are many: of each relation the first released one and the first with each end.
    kinds: dict[tuple, Trial] = {}
    for trial in Trial.read(path("trials")):
        if trial.measured.ended is not None or trial.candidate.id in episodes:
            kinds.setdefault((trial.candidate.relation, trial.measured.ended), trial)
    some = [*kinds.values()]
    path("candidates").write_text(lines(trial.candidate for trial in some))
    trials.run(path("scenes"), path("candidates"), CONFIG, path("trials"), cache)
    assert Trial.read(path("trials")) == some
    verdict.run(path("trials"), CONFIG, path("admissible"))
    certification.run(path("admissible"), path("trials"), CONFIG, path("certified"), cache)
    made = {record.id: record.runs for record in Certification.read(path("certified"))}
    by_id = {trial.candidate.id: trial for trial in some}
    kept = [episode for episode in episodes.values() if episode.id in by_id]
    assert {episode.relation for episode in kept} == relations
    for episode in kept:
        assert release.episode(by_id[episode.id], made[episode.id], CONFIG).to_json() == episode.to_json()
    path("episodes").write_text(lines(kept))
    for arm in (arm for arm in of_kind(ARMS, Kind.EMBODIED) if arm.positions is Source.HANDED):
        of_arm, settings = job(arm.name)
        made_rollouts = tmp_path / "rollouts" / f"{arm.name}.jsonl"
        rollouts.run(of_arm, settings, path("episodes"), [0], made_rollouts, cache, sightings_file=SIGHTINGS)
        scores.run([of_arm], path("episodes"), made_rollouts.parent, tmp_path / "scores")
        released = Score.read(DATA / "scores" / MAIN / f"{arm.name}.jsonl")
        wanted = [run for run in released if run.seed == 0 and run.episode in {episode.id for episode in kept}]
        assert Score.read(tmp_path / "scores" / f"{arm.name}.jsonl") == wanted
