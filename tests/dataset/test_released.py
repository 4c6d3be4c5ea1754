"""The data set in dataset/ is the release in data/, but for the tours, which git does not hold: its card lists all or none."""

from __future__ import annotations

import hashlib

import pytest
from pyarrow import parquet

from ovman.dataset.making import CARD, CROISSANT, SUMS
from ovman.dataset.tables import EPISODES, PREDICTIONS, RUNS, TOURS, episode_rows, read_answers
from ovman.records.episode import Episode
from tests.arms import CONFIG
from tests.episodes import DATA, ROOT

DATASET = ROOT / "dataset"
SPLITS = tuple(CONFIG.splits)


@pytest.fixture(scope="module")
def released():
    """The episodes of every split."""
    return {split: Episode.load(DATA / "episodes" / f"{split}.jsonl") for split in SPLITS}


def test_every_file_has_its_checksum(released):
    lines = (DATASET / SUMS).read_text(encoding="utf-8").splitlines()
    named = {name: digest for digest, name in (line.split("  ", 1) for line in lines)}
    scenes = {TOURS.file(split, episode.scene) for split, some in released.items() for episode in some}
    there = {path.relative_to(DATASET).as_posix() for path in DATASET.rglob("*") if path.is_file()} - {SUMS}
    assert {*named} in (there, there | scenes) and {CROISSANT, CARD} < there
    for name in there:
        assert hashlib.sha256((DATASET / name).read_bytes()).hexdigest() == named[name], name


def test_the_tables_are_the_release(released):
    of = {episode.id: split for split, some in released.items() for episode in some}
    runs, predictions = (read_answers(DATA / folder, of) for folder in ("scores", "predictions"))
    for split, some in released.items():
        for table, rows in {
            EPISODES: [*episode_rows(some)],
            RUNS: runs.get(split, []),
            PREDICTIONS: predictions.get(split, []),
        }.items():
            file = DATASET / table.file(split)
            empty = {column.name: None for column in table.columns}  # columns that came after the release
            assert [empty | row for row in (parquet.read_table(file).to_pylist() if file.is_file() else [])] == rows
            assert table is not EPISODES or len(rows) == len(some)
