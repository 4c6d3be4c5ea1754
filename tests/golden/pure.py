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
from ovman.analysis import controls, coverage, metrics, overview, sensitivity, split_significance, splits
from ovman.analysis.registry import in_all_tables, in_tables
from ovman.evaluation import predictions, scores
from ovman.evaluation.held_out_queries import ask
from ovman.generation import candidates, readmission, release, verdict
from ovman.language.held_out import HELD_OUT, read_held_out
from ovman.language.parser import parse
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.report.tables import stages
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
        scenes = CONFIG.splits[split].scenes
        release.run(
            [given / "trials" / f"{scene}.jsonl" for scene in scenes],
            [made / "admissible" / f"{scene}.jsonl" for scene in scenes],
            [given / "certified" / f"{scene}.jsonl" for scene in scenes],
            stage_settings(CONFIG, "episodes"),
            made / "episodes" / f"{split}.jsonl",
            made / "episodes" / f"{stem}sightings.jsonl",
            made / "metrics" / f"{stem}rejections.csv",
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
    answered = {path.stem for path in (given / "predictions").glob("*.jsonl")} | {
        path.stem for path in (made / "scores/main").iterdir()
    }
    metrics.run(
        given / "episodes" / "main.jsonl",
        sorted((given / "predictions").glob("*.jsonl")),
        sorted((given / "scores").glob("*/seed*/*.jsonl")),
        stage_settings(CONFIG, "metrics"),
        made / "metrics",
        [arm for arm in ARMS if arm.name in answered],
    )
    for split in SPLITS:
        episodes, judged = given / "episodes" / f"{split}.jsonl", stage_settings(CONFIG, "split_metrics")
        arms = CONFIG.splits[split].arms
        answers, runs = (
            [file for arm in arms if (file := given / stage / split / f"{arm}.jsonl").exists()]
            for stage in ("predictions", "scores")
        )
        splits.run(episodes, answers, judged, *_outcomes(made, split))
        splits.run_embodied(episodes, runs, judged, *_outcomes(made, f"{split}_embodied"))
    sensitivity.run(
        given / "readmitted" / "admissions.jsonl",
        given / "readmitted" / "episodes.jsonl",
        *(given / "readmitted" / "predictions" / f"{arm}.jsonl" for arm in ("two_visits", "single_visit")),
        stage_settings(CONFIG, "sensitivity"),
        made / "metrics" / "sensitivity.csv",
    )


def _outcomes(made: Path, kind: str) -> list[Path]:
    return [made / "metrics" / f"{kind}_{what}.csv" for what in ("outcomes", "rates")]


def _tabulate(given: Path, made: Path) -> None:
    across = {"controls": controls, "coverage": coverage, "overview": overview, "split_significance": split_significance}
    for folder, asked in ((made / "metrics", SPLITS), (made / "metrics" / "paper", SPLITS[:1])):
        folder.mkdir(exist_ok=True)
        kinds = ["static", "embodied", *(kind for split in asked for kind in (split, f"{split}_embodied"))]
        outcomes, rates = ([_outcomes(made, kind)[which] for kind in kinds] for which in (0, 1))
        for name, module in across.items():
            module.run(rates, outcomes, stage_settings(CONFIG, "controls"), folder / f"{name}.csv")

    def found(name: str, *folders: str) -> Path:
        places = [root / folder / f"{name}.csv" for folder in folders for root in (made, given)]
        return next(place for place in places if place.exists())

    paper = [*in_tables(ARMS, [CONFIG.splits["multi"]])]
    files = [found(name, "metrics") for name in paper] + [found(name, "metrics/paper") for name in across]
    stages.run(files, stage_settings(CONFIG, "tables"), made / "tables")
    added = in_all_tables(ARMS, [CONFIG.splits["everyday"]])
    stages.run_split([found(name, "metrics") for name in added], stage_settings(CONFIG, "split_tables"), made / "all")


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
