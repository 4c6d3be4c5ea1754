"""A further split goes through the stages of the main one, to its table and its pages, and changes no record of main."""

from __future__ import annotations

import csv
import shutil
from pathlib import Path

import pytest

from ovman.records.episode import VARIANTS, Episode
from ovman.records.visit import Sightings
from ovman.report.show.results import Results
from ovman.settings import Kind, arms_of
from ovman.task import referents
from ovman.workflow.parameter import stage_settings
from tests.workflow.conftest import World
from tests.workflow.test_reruns import CONFIG

SPLIT = CONFIG.splits["multi"]
STATIC = [arm for arm in SPLIT.arms if CONFIG.arms[arm].kind is Kind.STATIC]


def of(world, name: str) -> Path:
    return world.directory / "results" / name


def test_its_episodes_have_several_changes_and_one_referent(world):
    episodes = Episode.load(of(world, "episodes/multi.jsonl"))
    main = {episode.id for episode in Episode.load(of(world, "episodes/main.jsonl"))}
    wanted = {relation: count for relation, count in SPLIT.episodes if count}
    assert {relation: sum(e.relation == relation for e in episodes) for relation in wanted} == wanted
    for episode in episodes:
        assert episode.split == "multi" and episode.id not in main
        assert len(episode.changes) == len(episode.changed) in SPLIT.changes
        assert len({change.kind for change in episode.changes}) == len(episode.changes)
        assert all(run.success for run in episode.certification)
        assert referents(*episode.states, episode.query, stage_settings(CONFIG, "admissible")) == (episode.target,)
    seen = Sightings.read(of(world, "episodes/multi_sightings.jsonl"))
    assert [record.episode for record in seen] == [episode.id for episode in episodes]


def test_its_table_has_the_arms_that_its_entry_names(world):
    with of(world, "tables/multi.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(STATIC) == len(list(of(world, "predictions/multi").glob("*.jsonl")))
    assert {row["n"] for row in rows} == {str(sum(count for _, count in SPLIT.episodes))}
    assert of(world, "tables/multi_rejections.csv").is_file()


def test_its_episodes_are_shown_with_what_arms_answered(world):
    results = Results(world.directory / "results", arms_of(CONFIG.arms), {"multi": (), "everyday": ()})
    (chosen,) = results.chosen(["*/multi-*"])
    assert {*results.predictions(chosen)} == {*STATIC}
    assert all(results.static_verdict(arm, 0, chosen) for arm in STATIC)
    assert results.sightings(results.episodes[chosen]) is not None
    assert results.map(results.episodes[chosen], "second") is not None


@pytest.mark.soak
def test_what_its_settings_cost_is_a_table_of_its_own(world, tmp_path):
    again = World(shutil.copytree(world.directory, tmp_path / "world"))
    said = again.snakemake(target="results/ablation/everyday/table")
    assert said.returncode == 0, said.stdout
    with next(of(again, "ablation/everyday/table").glob("*.csv")).open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows and {file.stem for file in of(again, "ablation/everyday/episodes").glob("*.jsonl")} == {*VARIANTS}
    assert again.planned(target="results/ablation/everyday/table") == {}
    before, after = world.results(), again.results()
    assert {name: after[name] for name in before} == before
