"""The metrics as the page reads them: one number at a time, each knowing the file and the rows that it comes from."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path

import numpy as np
import pandas as pd
from pydantic import BaseModel, ConfigDict
from scipy.stats import fisher_exact

from ovman.analysis.difficulty import MANY
from ovman.settings import Comparisons, PaperRows

ALL = "all"
TWO_INSTANCES, MORE_INSTANCES = "2", f"{MANY}+"
"""Groups of the file "difficulty" that Fisher's test compares."""
_IDENTIFYING = ("seed", "arm_run", "baseline_run", "group")
"""Columns that say which of several rows is the extreme one."""
_LEAST_SCENES = 3


class Missing(LookupError):
    """A figure that the metrics do not have; the message says which, in one line."""


class Take(StrEnum):
    """What is made of several rows; see statements.yaml."""

    MEAN = "mean"
    MIN = "min"
    MAX = "max"
    DISTINCT = "distinct"
    FEWEST = "fewest"
    SECOND = "second"
    MOST = "most"
    FISHER = "fisher"


class Reading(BaseModel):
    """Where a number of the metrics is; statements.yaml says what each field is."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    file: str
    where: Mapping[str, str | tuple[str, ...]] = {}
    column: str = "rate"
    nth_seed: int | None = None
    query: str | None = None
    default: float | None = None
    take: Take | None = None
    least_rows: int = 1
    minus: Reading | None = None

    def of_arms(self, arms: Mapping[str, str]) -> Reading:
        """The same number of other arms: rows of the paper by the rows that they stand for."""

        def other(text: str | tuple[str, ...]) -> str | tuple[str, ...]:
            return arms.get(text, text) if isinstance(text, str) else tuple(arms.get(one, one) for one in text)

        where = {column: other(text) for column, text in self.where.items()}
        return self.model_copy(update={"where": where, "minus": self.minus and self.minus.of_arms(arms)})


@dataclass(frozen=True, slots=True)
class Cell:
    """A finite number, and where it is from: "static_rates.csv (two_visits, all): rate"."""

    value: float
    source: str


class Metrics:
    """The files of results/metrics by the names of the files without ending, all cells text.

    arms: by "static.two" and the like the arm that stands beside a row of the paper, and by "agent" the agent.
    """

    def __init__(self, files: Mapping[str, pd.DataFrame], arms: Mapping[str, str]) -> None:
        self._files, self._arms = files, arms

    @classmethod
    def load(cls, paths: Iterable[Path], arms: Mapping[str, str]) -> Metrics:
        """From csv files with a header. Raises ValueError in one line for a file without one."""
        files = {}
        for path in paths:
            try:
                files[path.stem] = pd.read_csv(path, dtype=object, keep_default_na=False, encoding="utf-8")
            except pd.errors.EmptyDataError:
                raise ValueError(f"{path}: no header; make it again: snakemake {path}") from None
        return cls(files, arms)

    def frame(self, file: str) -> pd.DataFrame:
        """All rows of a file, at least one. Raises Missing for a file or rows that are absent."""
        if file not in self._files:
            raise Missing(f"there is no {file}.csv")
        if self._files[file].empty:
            raise Missing(f"{file}.csv has no rows")
        return self._files[file]

    def read(self, reading: Reading) -> Cell:
        """The number that `reading` names.

        Raises Missing where there is no such row or its cell is empty; ValueError in one line for several rows where one is
        meant, for an absent column, and for a cell that is no finite number.
        """
        rows, words = self.rows(reading)
        cell = _taken(reading, rows, words)
        if reading.minus is None:
            return cell
        other = self.read(reading.minus)
        return Cell(cell.value - other.value, f"{cell.source} − {other.source}")

    def find(self, reading: Reading) -> Cell | None:
        """The number that `reading` names, or None where the metrics do not have it."""
        try:
            return self.read(reading)
        except Missing:
            return None

    def rows(self, reading: Reading) -> tuple[pd.DataFrame, str]:
        """The rows that `where` and `nth_seed` name, at least one, and the same in words. Raises as `read`."""
        rows = self.frame(reading.file)
        where = {key: self._arm(text) if isinstance(text, str) else text for key, text in reading.where.items()}
        if "relation" in rows.columns:
            where.setdefault("relation", ALL)
        chosen = np.ones(len(rows), bool)
        for column, text in where.items():
            values = _column(reading.file, rows, column).to_numpy()
            chosen &= np.any([values == one for one in ([text] if isinstance(text, str) else text)], axis=0)
        rows = rows[chosen]
        words = ", ".join(text if isinstance(text, str) else " and ".join(text) for text in where.values())
        if reading.nth_seed is not None:
            seeds = sorted(set(_column(reading.file, rows, "seed")), key=int)
            if reading.nth_seed >= len(seeds):
                raise Missing(
                    f"{reading.file}.csv has {len(seeds)} of the {reading.nth_seed + 1} seeds of {words} that are needed"
                )
            rows, words = rows[rows["seed"] == seeds[reading.nth_seed]], f"{words}, seed {seeds[reading.nth_seed]}"
        if len(rows) < reading.least_rows:
            few = f"one row of {words}, which cannot differ from others" if len(rows) else f"no row of {words}"
            raise Missing(f"{reading.file}.csv has {few}")
        return rows, words

    def _arm(self, text: str) -> str:
        if text in self._arms:
            return self._arms[text]
        if text.startswith(("static.", "embodied.")):
            raise Missing(f"section paper of config.yaml names no arm for {text}")
        if text.startswith("controls."):
            raise Missing(f"no entry of comparisons.controls in config.yaml has the role of {text}")
        return text


def arms_by_row(comparisons: Comparisons, paper: PaperRows) -> dict[str, str]:
    """The first arm beside each row of the paper's tables, by "static.two" and the like, the agent by "agent", and controls by
    their roles, "controls.depth"."""
    arms = {"agent": comparisons.agent}
    arms |= {f"controls.{entry.role}": name for name, entry in comparisons.controls.items() if entry.role}
    for table, rows in (("static", paper.static), ("embodied", paper.embodied)):
        for arm, row in rows.items():
            arms.setdefault(f"{table}.{row}", arm)
    return arms


def _taken(reading: Reading, rows: pd.DataFrame, words: str) -> Cell:
    file, column, of = f"{reading.file}.csv", reading.column, len(rows)
    if reading.query is not None:
        rows = rows.loc[_numbers(reading, reading.query, rows, words).query(reading.query).index]
        words += f", {len(rows)} of {of} rows with {reading.query}"
        if rows.empty and reading.default is not None:
            return Cell(reading.default, f"{file} ({words}): {column}")
    match reading.take:
        case None:
            if of > 1:
                raise ValueError(f"{file}: {of} rows of {words}, there must be one; make the metrics again")
            value = _values(reading, rows, words).iloc[0]
        case Take.DISTINCT:
            names = [_column(reading.file, rows, name.strip()) for name in column.split(",")]
            value, words = len(set(zip(*names, strict=True))), f"{words}, distinct"
        case Take.FEWEST | Take.SECOND | Take.MOST:
            value, words = _of_scenes(reading, rows, words)
        case Take.FISHER:
            value, words = _fall(reading, rows, words), f"{words}, {TWO_INSTANCES} against {MORE_INSTANCES} instances"
            column = f"{column}, n"
        case Take.MEAN:
            value, words = _values(reading, rows, words).mean(), f"{words}, mean of {of}"
        case _:
            values = _values(reading, rows, words).to_list()
            value = min(values) if reading.take is Take.MIN else max(values)
            chosen = rows.iloc[values.index(value)]
            which = [f"{name} {chosen[name]}" for name in _IDENTIFYING if name in rows and chosen[name]]
            words = ", ".join([words, f"{'lowest' if reading.take is Take.MIN else 'highest'} of {len(values)}", *which])
    return Cell(float(value), f"{file} ({words}): {column}")


def _values(reading: Reading, rows: pd.DataFrame, words: str) -> pd.Series[float]:
    """The column of a reading, or the expression of columns."""
    numbers = _numbers(reading, reading.column, rows, words)
    return pd.Series(numbers[reading.column] if reading.column in numbers else numbers.eval(reading.column), dtype="float64")


def _numbers(reading: Reading, expression: str, rows: pd.DataFrame, words: str) -> pd.DataFrame:
    """The columns that an expression names, as finite numbers. Missing for an empty cell, ValueError for another text."""
    columns = {
        name: [_number(text, f"{reading.file}.csv ({words}): {name}") for text in _column(reading.file, rows, name)]
        for name in re.findall(r"[a-z]\w*", expression)
    }
    return pd.DataFrame(columns, index=rows.index, dtype="float64")


def _number(text: str, source: str) -> float:
    if not text:
        raise Missing(f"{source} is empty")
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{source} is {text!r}, which is no finite number; make the metrics again")
    return value


def _column(file: str, rows: pd.DataFrame, name: str) -> pd.Series[str]:
    if name not in rows.columns:
        raise ValueError(f"{file}.csv: no column {name}, there are {', '.join(rows.columns)}; make the metrics again")
    column: pd.Series[str] = rows[name]
    return column


def _of_scenes(reading: Reading, rows: pd.DataFrame, words: str) -> tuple[float, str]:
    """The lowest, second lowest or highest mean of a scene, with its name."""
    rows = rows[_column(reading.file, rows, "scene") != ALL]
    means = _values(reading, rows, words).groupby(rows["scene"]).mean().sort_values(kind="stable")
    if len(means) < _LEAST_SCENES:
        raise Missing(f"{reading.file}.csv has {len(means)} scenes, which is too few to tell one from the others")
    place = {Take.FEWEST: 0, Take.SECOND: 1}.get(reading.take or Take.MOST, -1)
    return means.iloc[place], f"{words}, {means.index[place]}, mean over runs"


def _fall(reading: Reading, rows: pd.DataFrame, words: str) -> float:
    """One-sided p of Fisher's exact test that success with two instances of the category exceeds that with the most."""
    table = []
    for group in (TWO_INSTANCES, MORE_INSTANCES):
        of_group = rows[_column(reading.file, rows, "group") == group]
        if of_group.empty:
            raise Missing(f"{reading.file}.csv has no row of {words}, {group}")
        (won, n), *_ = _numbers(reading, f"{reading.column} n", of_group, f"{words}, {group}").to_numpy().tolist()
        if not 0 <= won <= n:
            raise ValueError(f"{reading.file}.csv ({words}, {group}): {won:g} successes of {n:g}; make the metrics again")
        table.append([round(won), round(n - won)])
    return float(fisher_exact(table, alternative="greater").pvalue)
