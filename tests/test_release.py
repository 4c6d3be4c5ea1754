"""The released records are what they say: whole, consistent, re-derivable, and made again to the same bytes."""

from __future__ import annotations

import hashlib
import json
from collections import Counter
from pathlib import Path

import pytest

from ovman.evaluation import predictions
from ovman.evaluation import rollouts as executions
from ovman.evaluation import scores as runs
from ovman.generation import admissible, candidates, certified, episodes, scenes, trials
from ovman.models.episode import Episode
from ovman.models.settings import Arm, Kind, Source, of_kind
from ovman.sim.recorded import judged
from ovman.task import Relation, referents
from ovman.workflow.config import load
from ovman.workflow.parameter import StageSettings, canonical
from tests.arms import ARMS

ROOT = Path(__file__).parent.parent
DATA = ROOT / "data" / "ovman-embedded-v1"
CONFIG = load(ROOT / "config.yaml")
REGENERATED = "FloorPlan318"


def constants(stage: str, arm: Arm | None = None) -> StageSettings:
    return StageSettings.parse(canonical(CONFIG, stage, arm and arm.name))


def records(path: Path) -> list[dict]:
    return [json.loads(line) for line in path.read_text().splitlines()]


@pytest.fixture(scope="module")
def released():
    return Episode.load(DATA / "episodes" / "main.jsonl")


def test_every_file_has_its_checksum():
    sums = dict(reversed(line.split("  ", 1)) for line in (DATA / "SHA256SUMS").read_text().splitlines())
    files = {p.relative_to(DATA).as_posix() for p in DATA.rglob("*") if p.is_file()} - {"SHA256SUMS"}
    assert set(sums) == files
    for name, checksum in sums.items():
        assert hashlib.sha256((DATA / name).read_bytes()).hexdigest() == checksum, name


def test_the_split_is_the_papers(released):
    counts = Counter(e.relation.value for e in released)
    assert counts == {"moved": 33, "former": 38, "moving": 36, "stable": 32, "appeared": 40, "removed": 40}
    assert len({e.scene for e in released}) == 20 == len(CONFIG.benchmark.scenes)


def test_every_episode_was_completed_four_times_and_its_referent_is_unique(released):
    task = constants("admissible")
    for episode in released:
        assert len(episode.certification) == 1 + CONFIG.admissibility.runs
        assert all(run.success for run in episode.certification), episode.id
        assert referents(*episode.states, episode.query, task) == (episode.target,), episode.id


def test_verdicts_episodes_and_audit_follow_from_the_released_measurements(tmp_path):
    files = [f"{scene}.jsonl" for scene in CONFIG.benchmark.scenes]
    for name in files:
        admissible.run(DATA / "trials" / name, constants("admissible"), tmp_path / name)
    folders = (DATA / "trials", tmp_path, DATA / "certified")
    inputs = [[folder / name for name in files] for folder in folders]
    episodes.run(*inputs, constants("episodes"), tmp_path / "main.jsonl", tmp_path / "rejections.csv")
    assert (tmp_path / "main.jsonl").read_bytes() == (DATA / "episodes" / "main.jsonl").read_bytes()
    assert (tmp_path / "rejections.csv").read_bytes() == (DATA / "metrics" / "rejections.csv").read_bytes()


def test_predictions_judgements_rates_and_tables_follow_from_the_released_records(tmp_path):
    episodes_file = DATA / "episodes" / "main.jsonl"
    trial_files = sorted((DATA / "trials").glob("*.jsonl"))
    # What the others answer hangs on maps, which networks make.
    for arm in (arm for arm in of_kind(ARMS, Kind.STATIC) if arm.positions is Source.HANDED):
        predictions.run(arm, episodes_file, trial_files, constants("predictions", arm), tmp_path / f"{arm.name}.jsonl")
        assert (tmp_path / f"{arm.name}.jsonl").read_bytes() == (DATA / "predictions" / f"{arm.name}.jsonl").read_bytes()
    run_files = sorted((DATA / "runs").rglob("*.jsonl"))
    task = constants("runs").success
    for file in run_files:
        for run in records(file):
            relation = Relation(run["episode"].split("/")[1])
            assert judged(run, relation, task) == run["success"], run


def test_a_scene_is_made_again_to_the_same_bytes(tmp_path):
    scene = REGENERATED

    def journal(stage: str) -> Path:
        return tmp_path / "journal" / f"{stage}.jsonl"

    def path(stage: str, suffix: str = "jsonl") -> Path:
        return tmp_path / f"{stage}.{suffix}"

    scenes.run(scene, constants("scenes"), path("scene", "json"), journal("scenes"))
    assert path("scene", "json").read_bytes() == (DATA / "scenes" / f"{scene}.json").read_bytes()
    candidates.run(path("scene", "json"), constants("candidates"), path("candidates"))
    visits = tmp_path / "visits"
    trials.run(path("candidates"), path("scene", "json"), constants("trials"), path("trials"), visits, journal("trials"))
    assert path("trials").read_bytes() == (DATA / "trials" / f"{scene}.jsonl").read_bytes()
    admissible.run(path("trials"), constants("admissible"), path("admissible"))
    (tmp_path / f"{scene}.jsonl").write_bytes(path("trials").read_bytes())
    certified.run(
        path("admissible"), tmp_path / f"{scene}.jsonl", constants("certified"), path("certified"), journal("certified")
    )
    made = {c["id"]: c["runs"] for c in records(path("certified"))}
    by_id = {t["candidate"]["id"]: t for t in records(path("trials"))}
    task = constants("episodes").success
    kept = [e for e in records(DATA / "episodes" / "main.jsonl") if e["scene"] == scene]
    assert kept
    for record in kept:
        again = episodes.episode(by_id[record["id"]], made[record["id"]], CONFIG.benchmark.backend, task)
        assert episodes.Episode.from_json(again).to_json() == record
    for arm in (arm for arm in of_kind(ARMS, Kind.EMBODIED) if arm.positions is Source.HANDED):
        outputs = {0: tmp_path / f"{arm.name}.jsonl"}
        main, of_arm = DATA / "episodes" / "main.jsonl", constants("executions", arm)
        executions.run(of_arm.arm, scene, main, path("trials"), of_arm, outputs, journal(arm.name))
        runs.run([outputs[0]], DATA / "episodes" / "main.jsonl", constants("runs"), [tmp_path / "judged.jsonl"])
        assert (tmp_path / "judged.jsonl").read_bytes() == (DATA / "runs" / arm.name / "seed0" / f"{scene}.jsonl").read_bytes()
