"""Recompute the pure stages of the benchmark from the released records.

This is the only file of `make golden` that imports OVMAN: a change of a stage function is followed here.
"""

from __future__ import annotations

import contextlib
import io
import json
import shutil
import tarfile
from pathlib import Path
from typing import Any

from ovman import seeds
from ovman.analysis import metrics, probes, splits
from ovman.analysis.language import ask
from ovman.analysis.registry import all_tables, paper_tables
from ovman.evaluation import predictions, scores
from ovman.generation import candidates, readmission, release, verdict
from ovman.language.held_out import HELD_OUT, read_held_out
from ovman.language.parser import parse
from ovman.records.episode import Episode
from ovman.records.scene import Scene
from ovman.report.tables import write_paper_tables, write_tables
from ovman.settings import Withheld, arms_of
from ovman.settings.config import load
from ovman.settings.settings import arm_job

ROOT = Path(__file__).parents[2]
RELEASE = ROOT / "data" / "ovman-embedded-v6"
CONFIG = load(ROOT / "config.yaml")
ARMS = arms_of(CONFIG.arms)
SPLITS = ("multi", "everyday", "rooms")
DRAWN = ("FloorPlan1", "FloorPlan16", "FloorPlan330", "FloorPlan429")
"""Scenes whose candidates are drawn: all would take two minutes."""


def unpack(directory: Path) -> Path:
    """Lay the released results below a directory, whatever code and settings made them; return the folder."""
    made = directory / "results"
    for folder in (path for path in RELEASE.iterdir() if path.is_dir()):
        shutil.copytree(folder, made / folder.name)
    with tarfile.open(RELEASE / "measurements.tar.xz") as archive:
        archive.extraction_filter = getattr(tarfile, "data_filter", None)
        archive.extractall(made, [one for one in archive if not one.name.startswith("cache/")])
    return made


def recompute(given: Path, made: Path) -> None:
    """Make what follows from given results, in the same layout."""
    with contextlib.redirect_stdout(io.StringIO()):
        _generate(given, made)
        _judge(given, made)
        _tabulate(given, made)
        _draw_sentences(given, made)
    _leave_out_new(given, made)


def _leave_out_new(given: Path, made: Path) -> None:
    """Remove files of metrics and tables that the release does not have yet. One that it has and that is not made is noticed."""
    for path in [path for folder in ("metrics", "tables", "all") for path in (made / folder).rglob("*.*")]:
        if not (given / path.relative_to(made)).exists():
            path.unlink()


def _generate(given: Path, made: Path) -> None:
    for stage in ("candidates", "admissible", "episodes", "sightings", "metrics", "readmitted"):
        (made / stage).mkdir(parents=True)
    for split in CONFIG.splits:
        file = f"{split}.jsonl"
        verdict.run(given / "trials" / file, CONFIG, made / "admissible" / file)
        (made / "metrics" / split).mkdir(parents=True, exist_ok=True)
        inputs = [root / stage / file for root, stage in ((given, "trials"), (made, "admissible"), (given, "certified"))]
        outputs = made / "episodes" / file, made / "sightings" / file, made / "metrics" / split / "rejections.csv"
        release.run(*inputs, CONFIG, *outputs, split)
    scenes = made / "scenes.jsonl"
    for split in CONFIG.splits:
        lines = (given / "scenes" / f"{split}.jsonl").read_text(encoding="utf-8").splitlines(keepends=True)
        scenes.write_text("".join(line for line in lines if json.loads(line)["scene"] in DRAWN), encoding="utf-8")
        candidates.run(split, scenes, CONFIG, made / "candidates" / f"{split}.jsonl")
        file = given / "candidates" / f"{split}.jsonl"
        lines = file.read_text(encoding="utf-8").splitlines(keepends=True)
        file.write_text("".join(line for line in lines if json.loads(line)["scene"] in DRAWN), encoding="utf-8")
    scenes.unlink()
    readmission.run(
        given / "trials" / "main.jsonl",
        given / "episodes" / "main.jsonl",
        CONFIG,
        made / "readmitted" / "episodes.jsonl",
        made / "readmitted" / "admissions.jsonl",
    )


def _judge(given: Path, made: Path) -> None:
    for split in ("main", *SPLITS):
        rollouts = given / "rollouts" / split
        judged = [
            arm_job(CONFIG, arm.name)
            for arm in ARMS
            if arm.kind == "embodied"
            and (rollouts / f"{arm.cut_from or arm.name}.jsonl").exists()
            and (given / "scores" / split / f"{arm.name}.jsonl").exists()
        ]
        scores.run(judged, given / "episodes" / f"{split}.jsonl", rollouts, made / "scores" / split)
        answers, runs = (sorted((given / stage / split).glob("*.jsonl")) for stage in ("predictions", "scores"))
        metrics.write_metrics(given / "episodes" / f"{split}.jsonl", answers, runs, CONFIG, made / "metrics" / split)
    probes.write_sensitivity(
        given / "readmitted" / "admissions.jsonl",
        given / "readmitted" / "episodes.jsonl",
        *(given / "readmitted" / "predictions" / f"{arm}.jsonl" for arm in ("two_visits", "single_visit")),
        CONFIG,
        made / "metrics" / "sensitivity.csv",
    )
    probes.write_tolerances(
        given / "trials" / "main.jsonl",
        given / "episodes" / "main.jsonl",
        given / "readmitted" / "episodes.jsonl",
        *(given / "readmitted" / "predictions" / f"{arm}.jsonl" for arm in ("two_visits", "single_visit")),
        CONFIG,
        made / "metrics" / "tolerances.csv",
    )


def _tabulate(given: Path, made: Path) -> None:
    for folder, asked in (("", SPLITS), ("paper", SPLITS[:1])):
        directories = {split: made / "metrics" / split for split in ("main", *asked)}
        splits.write_across_splits(directories, CONFIG, made / "metrics" / folder)

    def found(names: list[str]) -> list[Path]:
        places = [[root / "metrics" / f"{name}.csv" for root in (made, given)] for name in names]
        return [next(place for place in some if place.exists()) for some in places]

    write_paper_tables(found(paper_tables(CONFIG)), CONFIG, made / "tables")
    write_tables(found(all_tables(CONFIG)), CONFIG, made / "all")


def _draw_sentences(given: Path, made: Path) -> None:
    held_out = read_held_out(HELD_OUT)
    (made / "language").mkdir()
    asked = [ask(episode, held_out) for episode in Episode.load(given / "episodes" / "main.jsonl")]
    text = "".join(f"{json.dumps(one.to_json())}\n" for one in asked)
    (made / "language" / "sentences.jsonl").write_text(text, encoding="utf-8")


def answer(sentence: str) -> str:
    """Return what the parser makes of a sentence."""
    return repr(parse(sentence))


def draws(root: int, names: list[Any]) -> list[int]:
    """Return the first words of a random stream, and the seed for programs that take an integer."""
    return [*map(int, seeds.sequence(root, *names).generate_state(2)), seeds.integer(root, *names)]


def withheld_queries(given: Path) -> dict[str, str]:
    """Return what arms are asked from which the noun or the relation is withheld, of every fifth episode."""
    asked = {}
    scenes = {scene.scene: scene for scene in Scene.read(given / "scenes" / "main.jsonl")}
    for episode in list(Episode.load(given / "episodes" / "main.jsonl"))[::5]:
        scene = scenes[episode.scene]
        categories = predictions.categories_of(scene).values()
        for what in Withheld:
            for run in (0, 1):
                query = predictions.query_of(episode, what, run, categories)
                asked[f"{episode.id} {what} {run}"] = f"{query.category} {query.relation}"
    return asked
