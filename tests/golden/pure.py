"""Recompute the pure stages of the benchmark from the released records.

This is the only file of `make golden` that imports OVMAN: a change of a stage function is followed here.
"""

from __future__ import annotations

import contextlib
import io
import json
import tarfile
from pathlib import Path
from typing import Any

from ovman import seeds
from ovman.analysis import metrics, probes, splits
from ovman.analysis.registry import all_tables, paper_tables
from ovman.evaluation import predictions, scores
from ovman.evaluation.held_out_queries import ask
from ovman.generation import candidates, readmission, release, verdict
from ovman.language.held_out import HELD_OUT, read_held_out
from ovman.language.parser import parse
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.report.tables import write_paper_tables, write_tables
from ovman.settings import Withheld, arms_of
from ovman.settings.config import load
from ovman.workflow.parameter import stage_settings

ROOT = Path(__file__).parents[2]
RELEASE = ROOT / "data" / "ovman-embedded-v2"
CONFIG = load(ROOT / "config.yaml")
ARMS = arms_of(CONFIG.arms)
SPLITS = ("multi", "everyday")
DRAWN = ("FloorPlan1", "FloorPlan16", "FloorPlan330", "FloorPlan429")
"""Scenes whose candidates are drawn: all would take two minutes."""


def unpack(directory: Path) -> Path:
    """Lay the released results below a directory as a run of the workflow would; return the folder."""
    made = directory / "results"
    for source in sorted(RELEASE.rglob("*.*")):
        name = source.relative_to(RELEASE)
        if len(name.parts) > 1 and source.is_file():
            place = made / ("scores" if name.parts[0] == "runs" else name.parts[0]) / Path(*name.parts[1:])
            place.parent.mkdir(parents=True, exist_ok=True)
            place.symlink_to(source)
    with tarfile.open(RELEASE / "measurements.tar.xz") as archive:
        archive.extractall(directory, [one for one in archive if "/journal/" not in one.name], filter="data")
    for file in (made / "candidates").iterdir():
        if file.stem not in DRAWN:
            file.unlink()
    return made


def recompute(given: Path, made: Path) -> None:
    """Make what follows from given results, in the same layout."""
    with contextlib.redirect_stdout(io.StringIO()):
        _generate(given, made)
        _judge(given, made)
        _tabulate(given, made)
        _draw_sentences(given, made)


def _generate(given: Path, made: Path) -> None:
    for stage in ("candidates", "admissible", "episodes", "metrics", "readmitted"):
        (made / stage).mkdir(parents=True)
    for scene in DRAWN:
        constants, drawn = stage_settings(CONFIG, "candidates"), made / "candidates" / f"{scene}.jsonl"
        candidates.run(given / "scenes" / f"{scene}.json", constants, drawn)
    trials = sorted((given / "trials").iterdir())
    for trial in trials:
        verdict.run(trial, stage_settings(CONFIG, "admissible"), made / "admissible" / trial.name)
    for split in ("main", *SPLITS, "dev", "dev_everyday"):
        stem = "" if split == "main" else f"{split}_"
        (made / "metrics" / split).mkdir(parents=True, exist_ok=True)
        scenes = CONFIG.splits[split].scenes
        release.run(
            [given / "trials" / f"{scene}.jsonl" for scene in scenes],
            [made / "admissible" / f"{scene}.jsonl" for scene in scenes],
            [given / "certified" / f"{scene}.jsonl" for scene in scenes],
            stage_settings(CONFIG, "episodes"),
            made / "episodes" / f"{split}.jsonl",
            made / "episodes" / f"{stem}sightings.jsonl",
            made / "metrics" / split / "rejections.csv",
            split,
        )
    for file in (made / "admissible").iterdir():
        if not (given / "admissible" / file.name).exists():  # the release leaves out those of dev
            file.unlink()
    readmission.run(
        [given / "trials" / f"{scene}.jsonl" for scene in CONFIG.splits["main"].scenes],
        given / "episodes" / "main.jsonl",
        stage_settings(CONFIG, "readmitted"),
        made / "readmitted" / "episodes.jsonl",
        made / "readmitted" / "admissions.jsonl",
    )


def _judge(given: Path, made: Path) -> None:
    for split in ("main", *SPLITS):
        folder = given / "rollouts" / ("" if split == "main" else split)
        for arm in (arm for arm in ARMS if arm.kind == "embodied"):
            files = sorted((folder / (arm.cut_from or arm.name)).glob("seed*/*.jsonl"))
            if files:
                rollouts = made / f"{split}_{arm.name}.jsonl"
                rollouts.write_bytes(b"".join(file.read_bytes() for file in files))
                judge = stage_settings(CONFIG, "scores", arm.name).arm
                scores.run(judge, given / "episodes" / f"{split}.jsonl", rollouts, made / "scores" / split / f"{arm.name}.jsonl")
    for split in ("main", *SPLITS):
        answers, runs = (sorted((given / stage / split).glob("*.jsonl")) for stage in ("predictions", "scores"))
        if split == "main":
            answers, runs = sorted((given / "predictions").glob("*.jsonl")), sorted((given / "scores").glob("*/seed*/*.jsonl"))
        episodes, constants = given / "episodes" / f"{split}.jsonl", stage_settings(CONFIG, "metrics")
        metrics.write_metrics(episodes, answers, runs, constants, made / "metrics" / split)
    probes.write_sensitivity(
        given / "readmitted" / "admissions.jsonl",
        given / "readmitted" / "episodes.jsonl",
        *(given / "readmitted" / "predictions" / f"{arm}.jsonl" for arm in ("two_visits", "single_visit")),
        stage_settings(CONFIG, "sensitivity"),
        made / "metrics" / "sensitivity.csv",
    )


def _tabulate(given: Path, made: Path) -> None:
    for folder, asked in (("", SPLITS), ("paper", SPLITS[:1])):
        directories = {split: made / "metrics" / split for split in ("main", *asked)}
        splits.write_across_splits(directories, stage_settings(CONFIG, "controls"), made / "metrics" / folder)

    def found(names: list[str]) -> list[Path]:
        places = [[root / "metrics" / f"{name}.csv" for root in (made, given)] for name in names]
        return [next(place for place in some if place.exists()) for some in places]

    write_paper_tables(found(paper_tables(CONFIG)), stage_settings(CONFIG, "tables"), made / "tables")
    write_tables(found(all_tables(CONFIG)), stage_settings(CONFIG, "split_tables"), made / "all")


def _draw_sentences(given: Path, made: Path) -> None:
    held_out = read_held_out(HELD_OUT)
    (made / "language").mkdir()
    asked = [ask(episode, held_out) for episode in Episode.load(given / "episodes" / "main.jsonl")]
    text = "".join(f"{json.dumps(one.to_json())}\n" for one in asked)
    (made / "language" / "sentences.jsonl").write_text(text, encoding="utf-8")


def answer(sentence: str) -> str:
    """What the parser makes of a sentence."""
    return repr(parse(sentence))


def draws(root: int, names: list[Any]) -> list[int]:
    """The first words of a random stream, and the seed for programs that take an integer."""
    return [*map(int, seeds.sequence(root, *names).generate_state(2)), seeds.integer(root, *names)]


def withheld_queries(given: Path) -> dict[str, str]:
    """What arms are asked from which the noun or the relation is withheld, of every fifth episode."""
    asked = {}
    for episode in list(Episode.load(given / "episodes" / "main.jsonl"))[::5]:
        (scene,) = Scene.read(given / "scenes" / f"{episode.scene}.json")
        categories = predictions.categories_of(scene).values()
        for what in Withheld:
            for run in (0, 1):
                query = predictions.query_of(episode, what, run, categories)
                asked[f"{episode.id} {what} {run}"] = f"{query.category} {query.relation}"
    return asked
