"""Read single numbers of results/metrics, each with the file, the rows and the column that it comes from."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd

from ovman.report.paper import EMPTY, RATE, Form, write
from ovman.settings import Comparisons, PaperRows

ALL = "all"
"""The value of column `relation` in the rows over all episodes."""
LEAST_SCENES = 3
"""One scene cannot be told from the others if there are fewer."""
_IDENTIFYING = ("seed", "arm_run", "baseline_run", "group")
"""Columns that say which row of several has the lowest or highest value."""


NOTHING: Mapping[str, str] = MappingProxyType({})


class Missing(LookupError):
    """Figures that the metrics do not have, named in one line."""


class Cell(float):
    """A number of the metrics, NaN if they lack it.

    Attributes:
        source: Where the number is from: "static_rates.csv (two_visits, all): rate".
        missing: What the metrics lack, in one line; empty if the number is there.
        form: How the number is written.
    """

    source: str
    missing: str
    form: Form

    def __new__(cls, value: float, source: str, missing: str = "", form: Form = RATE) -> Cell:
        """Make a number that knows its source."""
        cell = super().__new__(cls, value)
        cell.source, cell.missing, cell.form = source, missing, form
        return cell

    def __format__(self, form: str) -> str:
        """Write the number in its own form, or in the form or number format behind the colon of a format string."""
        if self.missing:
            return EMPTY
        if form and form not in set(Form):
            return format(float(self), form)
        return write(float(self), Form(form) if form else self.form)

    def written_as(self, form: Form) -> Cell:
        """Return the number with another form."""
        return Cell(self, self.source, self.missing, form)

    def __sub__(self, other: object) -> Cell:
        """Subtract another number of the metrics; the difference names both sources."""
        if not isinstance(other, Cell):
            return NotImplemented
        value = float(self) - float(other)
        return Cell(value, f"{self.source} − {other.source}", self.missing or other.missing)


def lacking(words: str) -> Cell:
    """Return the number that stands for one that the metrics lack."""
    return Cell(math.nan, "", words)


def derive(value: float, source: str, *of: Cell, form: Form = RATE) -> Cell:
    """Return a number that was computed from others, missing if one of them is. source: the computation in words."""
    return Cell(value, source, next((cell.missing for cell in of if cell.missing), ""), form)


class Metrics:
    """The files of results/metrics by the names of the files without ending. All cells are text.

    Args:
        files: Frames by name.
        arms: Arms by what statements call them: "static.two", "embodied.two", "agent", "controls.depth".
        instead: Such names that stand for others: the arms of another reading of a definition.
    """

    def __init__(self, files: Mapping[str, pd.DataFrame], arms: Mapping[str, str], instead: Mapping[str, str] = NOTHING) -> None:
        self._files, self._arms, self._instead = files, arms, instead

    @classmethod
    def load(cls, paths: Iterable[Path], arms: Mapping[str, str]) -> Metrics:
        """Read csv files with a header.

        Raises:
            ValueError: A file has no header.
        """
        files = {}
        for path in paths:
            try:
                files[path.stem] = pd.read_csv(path, dtype=object, keep_default_na=False, encoding="utf-8")
            except pd.errors.EmptyDataError:
                raise ValueError(f"{path}: no header; make it again: snakemake {path}") from None
        return cls(files, arms)

    def frame(self, file: str) -> pd.DataFrame:
        """Return all rows of a file, at least one.

        Raises:
            Missing: The file is absent or has no rows.
        """
        if file not in self._files:
            raise Missing(f"there is no {file}.csv")
        if self._files[file].empty:
            raise Missing(f"{file}.csv has no rows")
        return self._files[file]

    def rows(self, file: str, **where: str | tuple[str, ...]) -> Rows:
        """Return the rows with the given values; a tuple means any of its members. The relation is "all" if not given.

        Raises:
            ValueError: The file lacks a column.
        """
        try:
            frame = self.frame(file)
            values = {column: self._arm(value) if isinstance(value, str) else value for column, value in where.items()}
        except Missing as missing:
            return Rows(file, pd.DataFrame(), "", str(missing))
        if "relation" in frame.columns:
            values.setdefault("relation", ALL)
        rows = Rows(file, frame, ", ".join(value if isinstance(value, str) else " and ".join(value) for value in values.values()))
        chosen = np.ones(len(frame), bool)
        for column, value in values.items():
            column_values = rows.column(column).to_numpy()
            chosen &= np.any([column_values == one for one in ([value] if isinstance(value, str) else value)], axis=0)
        return rows.keep(frame[chosen])

    def _arm(self, name: str) -> str:
        name = self._instead.get(name, name)
        if name in self._arms:
            return self._arms[name]
        if name.startswith(("static.", "embodied.")):
            raise Missing(f"section paper of config.yaml names no arm for {name}")
        if name.startswith("controls."):
            raise Missing(f"no entry of comparisons.controls in config.yaml has the role of {name}")
        return name

    def with_arms(self, others: Mapping[str, str]) -> Metrics:
        """Return the same metrics with other arms in the place of some: both by what statements call them."""
        return Metrics(self._files, self._arms, others)


@dataclass(frozen=True)
class Rows:
    """Rows of one file. words: what they are rows of; missing: why there are none, in one line.

    Every method that reads a number gives a NaN with the reason where a row or a cell is missing, and raises ValueError in one
    line for an absent column and for a cell that is not a finite number.
    """

    file: str
    frame: pd.DataFrame
    words: str
    missing: str = ""

    def keep(self, frame: pd.DataFrame, words: str = "") -> Rows:
        """Return some of the rows, `words` added to what they are rows of."""
        words = f"{self.words}, {words}" if words else self.words
        missing = self.missing or ("" if len(frame) else f"{self.file}.csv has no row of {words}")
        return Rows(self.file, frame, words, missing)

    def of_seed(self, number: int) -> Rows:
        """Return the rows of one seed, counted from 0."""
        if self.missing:
            return self
        seeds = sorted(set(self.column("seed")), key=int)
        if number >= len(seeds):
            few = f"{self.file}.csv has {len(seeds)} of the {number + 1} seeds of {self.words} that are needed"
            return replace(self, missing=few)
        return self.keep(self.frame[self.frame["seed"] == seeds[number]], f"seed {seeds[number]}")

    def at_least(self, number: int) -> Rows:
        """Return the rows, or none if there are fewer than `number`."""
        if self.missing or len(self.frame) >= number:
            return self
        return replace(self, missing=f"{self.file}.csv has one row of {self.words}, which cannot differ from others")

    def column(self, name: str) -> pd.Series[str]:
        """Return a column as text.

        Raises:
            ValueError: The file lacks it.
        """
        if name not in self.frame.columns:
            there = ", ".join(self.frame.columns)
            raise ValueError(f"{self.file}.csv: no column {name}, there are {there}; make the metrics again")
        column: pd.Series[str] = self.frame[name]
        return column

    def values(self, expression: str) -> pd.Series[float]:
        """Return a column as numbers, or an arithmetic expression of columns.

        Raises:
            Missing: A cell is empty.
            ValueError: A column is absent or a cell is not a finite number.
        """
        columns = {name: [self._number(text, name) for text in self.column(name)] for name in re.findall(r"[a-z]\w*", expression)}
        numbers = pd.DataFrame(columns, index=self.frame.index, dtype="float64")
        return pd.Series(numbers[expression] if expression in numbers else numbers.eval(expression), dtype="float64")

    def one(self, column: str = "rate") -> Cell:
        """Return the number of the only row.

        Raises:
            ValueError: There are several rows.
        """
        if not self.missing and len(self.frame) > 1:
            raise ValueError(
                f"{self.file}.csv: {len(self.frame)} rows of {self.words}, there must be one; make the metrics again"
            )
        return self._take(column, lambda values: (values.iloc[0], ""))

    def mean(self, column: str = "rate") -> Cell:
        """Return the mean over the rows."""
        return self._take(column, lambda values: (values.mean(), f"mean of {len(values)}"))

    def lowest(self, column: str = "rate") -> Cell:
        """Return the lowest number of the rows."""
        return self._take(column, lambda values: self._find(min(values), values, "lowest"))

    def highest(self, column: str = "rate") -> Cell:
        """Return the highest number of the rows."""
        return self._take(column, lambda values: self._find(max(values), values, "highest"))

    def count_distinct(self, *columns: str) -> Cell:
        """Return how many different texts the columns have."""
        if self.missing:
            return lacking(self.missing)
        texts = {*zip(*map(self.column, columns), strict=True)}
        return Cell(len(texts), f"{self.file}.csv ({self.words}, distinct): {', '.join(columns)}")

    def lowest_positive(self, column: str, of: str, otherwise: float) -> Cell:
        """Return the lowest number of the rows whose column `of` is above 0; `otherwise` if there are none."""
        if self.missing:
            return lacking(self.missing)
        try:
            frame = self.frame[self.values(of) > 0]
        except Missing as missing:
            return lacking(str(missing))
        rows = Rows(self.file, frame, f"{self.words}, {len(frame)} of {len(self.frame)} rows with {of} > 0")
        return rows.lowest(column) if len(frame) else Cell(otherwise, f"{self.file}.csv ({rows.words}): {column}")

    def of_scene(self, place: int, column: str) -> Cell:
        """Return the mean of one scene over its rows. place: of the scene, from the lowest mean to the highest."""
        if self.missing:
            return lacking(self.missing)
        rows = replace(self, frame=self.frame[self.column("scene") != ALL])
        try:
            means = rows.values(column).groupby(rows.frame["scene"]).mean().sort_values(kind="stable")
        except Missing as missing:
            return lacking(str(missing))
        if len(means) < LEAST_SCENES:
            return lacking(f"{self.file}.csv has {len(means)} scenes, which is too few to tell one from the others")
        words = f"{self.words}, {means.index[place]}, mean over runs"
        return Cell(means.iloc[place], f"{self.file}.csv ({words}): {column}")

    def _take(self, column: str, take: Callable[[pd.Series[float]], tuple[float, str]]) -> Cell:
        """Return what `take` makes of a column, with its words added to the source."""
        if self.missing:
            return lacking(self.missing)
        try:
            value, words = take(self.values(column))
        except Missing as missing:
            return lacking(str(missing))
        words = f"{self.words}, {words}" if words else self.words
        return Cell(float(value), f"{self.file}.csv ({words}): {column}")

    def _find(self, value: float, values: pd.Series[float], called: str) -> tuple[float, str]:
        row = self.frame.iloc[values.to_list().index(value)]
        which = [f"{name} {row[name]}" for name in _IDENTIFYING if name in row and row[name]]
        return value, ", ".join([f"{called} of {len(values)}", *which])

    def _number(self, text: str, column: str) -> float:
        source = f"{self.file}.csv ({self.words}): {column}"
        if not text:
            raise Missing(f"{source} is empty")
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise ValueError(f"{source} is {text!r}, which is not a finite number; make the metrics again")
        return value


def name_arms(comparisons: Comparisons, paper: PaperRows) -> dict[str, str]:
    """Return the arms by what statements call them.

    These are the first arm next to each row of the paper's tables, "static.two", the agent, "agent", and controls by their roles,
    "controls.depth".
    """
    arms = {"agent": comparisons.agent}
    arms |= {f"controls.{entry.role}": name for name, entry in comparisons.controls.items() if entry.role}
    for table, rows in (("static", paper.static), ("embodied", paper.embodied)):
        for arm, row in rows.items():
            arms.setdefault(f"{table}.{row}", arm)
    return arms
