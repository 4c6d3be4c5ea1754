"""The released records are what they say: whole, consistent, re-derivable, and made again to the same bytes."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from pathlib import Path

import pytest

from ovman.analysis import metrics
from ovman.analysis.frames import read_rows
from ovman.analysis.rates import Rate
from ovman.evaluation import predictions, rollouts, scores
from ovman.evaluation.scoring import judged
from ovman.generation import candidates, certification, release, scenes, trials, verdict
from ovman.models.certification import Certification
from ovman.models.episode import Episode
from ovman.models.run import Score
from ovman.models.scene import Scene
from ovman.models.settings import Arm, Kind, Source, of_kind
from ovman.models.trial import Trial
from ovman.report.tables import stages
from ovman.report.tables.specs import SPECS
from ovman.task import referents, spl
from ovman.workflow.config import load
from ovman.workflow.parameter import StageSettings, canonical
from tests.arms import ARMS
from tests.episodes import DATA, EPISODES, SIGHTINGS

ROOT = Path(__file__).parent.parent
CONFIG = load(ROOT / "config.yaml")
REGENERATED = "FloorPlan318"
RESULTS_OF_0_4 = {
    "metrics": "852e146ae585f435ffce628cb209ea175920ecc12e378bea602c18fe524016b4",
    "predictions": "9b247f7ac89463fbb0959f536feb7b730b3a822db4e94c291026c789dbcb32be",
    "runs": "82d0a8cdc0f4efdace9d7c248fe5ee8d0d13e935a37550f9cc2bd764f46adf3d",
}
"""Digests of the checksums of 0.4's predictions, runs and metrics: their values stay as they were."""


NEW_NAMES = {"grounding.band": "grounding.similarity_margin", "minimum_mask_px": "min_mask_px"}
"""Settings that were named otherwise in 0.4."""


def renamed(table: str) -> str:
    """A table with the present names of settings."""
    for before, now in NEW_NAMES.items():
        table = table.replace(before, now)
    return table


def numbers(table: Path) -> list[str]:
    """The numbers in the body of a table in Markdown or LaTeX, in their order; its layout and its caption may change."""
    text = table.read_text()
    if table.suffix == ".md":
        body = "\n".join(line for line in text.splitlines() if line.startswith("|") and not re.fullmatch(r"[|:\- ]+", line))
    else:
        body = text[text.index(r"\midrule") : text.index(r"\bottomrule")]
    return re.findall(r"\d+(?:\.\d+)?", body)


def constants(stage: str, arm: Arm | None = None) -> StageSettings:
    return StageSettings.parse(canonical(CONFIG, stage, arm and arm.name))


@pytest.fixture(scope="module")
def released():
    return Episode.load(EPISODES)


def test_every_file_has_its_checksum():
    sums = dict(reversed(line.split("  ", 1)) for line in (DATA / "SHA256SUMS").read_text().splitlines())
    files = {p.relative_to(DATA).as_posix() for p in DATA.rglob("*") if p.is_file()} - {"SHA256SUMS"}
    assert set(sums) == files
    for name, checksum in sums.items():
        assert hashlib.sha256((DATA / name).read_bytes()).hexdigest() == checksum, name


@pytest.mark.parametrize("folder", sorted(RESULTS_OF_0_4))
def test_results_are_those_of_version_0_4(folder):
    files = sorted(path for path in (DATA / folder).rglob("*") if path.is_file())
    sums = "".join(f"{hashlib.sha256(path.read_bytes()).hexdigest()} {path.relative_to(DATA).as_posix()}\n" for path in files)
    assert hashlib.sha256(sums.encode()).hexdigest() == RESULTS_OF_0_4[folder]


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
        verdict.run(DATA / "trials" / name, constants("admissible"), tmp_path / name)
    surveyed = [DATA / "scenes" / f"{scene}.json" for scene in CONFIG.benchmark.scenes]
    inputs = [[folder / name for name in files] for folder in (DATA / "trials", tmp_path, DATA / "certified")]
    outputs = tmp_path / "main.jsonl", tmp_path / "sightings.jsonl", tmp_path / "rejections.csv"
    release.run(surveyed, *inputs, constants("episodes"), *outputs)
    for made, kept in zip(outputs, (EPISODES, SIGHTINGS, DATA / "metrics" / "rejections.csv"), strict=True):
        assert made.read_bytes() == kept.read_bytes(), kept.name


def test_predictions_judgements_rates_and_tables_follow_from_the_released_records(tmp_path, released):
    # What the other arms answer follows from maps, which networks make.
    for arm in (arm for arm in of_kind(ARMS, Kind.STATIC) if arm.positions is Source.HANDED):
        predictions.run(arm, EPISODES, constants("predictions", arm), tmp_path / f"{arm.name}.jsonl", SIGHTINGS)
        assert (tmp_path / f"{arm.name}.jsonl").read_bytes() == (DATA / "predictions" / f"{arm.name}.jsonl").read_bytes()
    run_files = sorted((DATA / "runs").rglob("*.jsonl"))
    episodes, judged_runs = {episode.id: episode for episode in released}, 0
    for file in run_files:
        for run in Score.read(file):
            episode = episodes[run.episode]
            assert judged(run, episode.relation, episode.protocol.success) == run.success, run
            assert round(spl(run.success, episode.shortest_path_m, run.path_length_m), 6) == run.spl, run
            judged_runs += 1
    assert judged_runs == len(episodes) * len(CONFIG.evaluation.seeds) * len(list(of_kind(ARMS, Kind.EMBODIED))) == 3285
    answered = {path.stem for path in (DATA / "predictions").iterdir()} | {path.name for path in (DATA / "runs").iterdir()}
    metrics.run(
        EPISODES,
        sorted((DATA / "predictions").glob("*.jsonl")),
        run_files,
        constants("metrics"),
        tmp_path / "metrics",
        [arm for arm in ARMS if arm.name in answered],
    )
    derived = {path.name: path for path in (tmp_path / "metrics").iterdir()}
    kept = sorted((DATA / "metrics").iterdir())
    for path in kept:
        assert path.name not in derived or derived[path.name].read_bytes() == path.read_bytes(), path.name
    shown = [derived.get(path.name, path) for path in kept if path.stem in SPECS]
    stages.run(shown, constants("tables"), tmp_path / "tables")
    for path in sorted((tmp_path / "tables").iterdir()):
        kept = DATA / "tables" / path.name
        if path.suffix == ".csv":
            assert renamed(kept.read_text()) == path.read_text(), path.name
        else:
            assert numbers(kept) == numbers(path), path.name


def test_what_must_come_out_does():
    rates = {(row.arm, row.relation): row.rate for row in read_rows(DATA / "metrics" / "static_rates.csv", Rate)}
    assert rates["positions_two_visits", "all"] >= 0.97
    rates = {(row.arm, row.relation): row.rate for row in read_rows(DATA / "metrics" / "embodied_rates.csv", Rate)}
    assert rates["oracle_check", "all"] >= 0.98
    assert rates["two_visits_oracle_positions", "all"] >= 0.97


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
    files = path("candidates"), path("scene", "json")
    trials.run(*files, constants("trials"), path("trials"), path("visits", "json"), visits, journal("trials"))
    assert Trial.read(path("trials")) == Trial.read(DATA / "trials" / f"{scene}.jsonl")
    verdict.run(path("trials"), constants("admissible"), path("admissible"))
    (tmp_path / f"{scene}.jsonl").write_bytes(path("trials").read_bytes())
    certification.run(
        path("admissible"), tmp_path / f"{scene}.jsonl", constants("certified"), path("certified"), journal("certified")
    )
    made = {record.id: record.runs for record in Certification.read(path("certified"))}
    by_id = {trial.candidate.id: trial for trial in Trial.read(path("trials"))}
    (surveyed,) = Scene.read(path("scene", "json"))
    kept = [episode for episode in Episode.load(EPISODES) if episode.scene == scene]
    assert kept
    for episode in kept:
        again = release.episode(by_id[episode.id], made[episode.id], surveyed, constants("episodes"))
        assert again.to_json() == episode.to_json()
    for arm in (arm for arm in of_kind(ARMS, Kind.EMBODIED) if arm.positions is Source.HANDED):
        outputs = {0: tmp_path / f"{arm.name}.jsonl"}
        of_arm = constants("rollouts", arm)
        rollouts.run(of_arm.arm, scene, EPISODES, of_arm, outputs, journal(arm.name), SIGHTINGS)
        scores.run([outputs[0]], EPISODES, [tmp_path / "judged.jsonl"], of_arm.arm)
        assert (tmp_path / "judged.jsonl").read_bytes() == (DATA / "runs" / arm.name / "seed0" / f"{scene}.jsonl").read_bytes()
