"""Read single numbers of results/metrics, each with the file, the rows and the column that it comes from."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from ovman.analysis.statistics import draw_resamples
from ovman.report.paper import COUNT, DIFFERENCE, EMPTY, EXPECTED, METRES, RATE, Form, P, write
from ovman.report.tables.table import ALL, read_metrics
from ovman.settings import Comparisons, Kind, PaperRows

_IDENTIFYING = ("seed", "arm_run", "baseline_run", "group")
"""Columns that say which row of several has the lowest or highest value."""
_FORMS: Mapping[str, Form] = {
    **dict.fromkeys(
        ("n", "count", "trials", "episodes", "successes", "successes_read_as", "wins", "losses", "gained", "lost"), COUNT
    ),
    **dict.fromkeys(("answered", "same", "only_read_as", "missing", "missing_wrong", "grounded", "grounded_wrong"), COUNT),
    **dict.fromkeys(("objects", "objects_mean", "rescued"), EXPECTED),
    **dict.fromkeys(("difference", "gain", "margin", "released_margin", "rate - chance"), DIFFERENCE),
    **dict.fromkeys(("p", "p_holm"), P),
}
"""How the numbers of a column are written; other columns have metres if their names end so, and rates."""


class Missing(LookupError):
    """Figures that the metrics do not have, named in one line."""


class Cell(float):
    """A number of the metrics.

    Attributes:
        source: Where it is from, "static_rates.csv (two_visits, all): rate".
        form: How it is written.
        draws: The number in each resample of the scenes, float64 (RESAMPLES,); None for a number that has no record by scene.
    """

    source: str
    form: Form
    draws: np.ndarray | None

    def __new__(cls, value: float, source: str, form: Form = RATE, draws: np.ndarray | None = None) -> Cell:
        """Make a number that knows its source."""
        cell = super().__new__(cls, value)
        cell.source, cell.form, cell.draws = source, form, draws
        return cell

    def __format__(self, spec: str) -> str:
        """Write the number in its own form, or in the number format behind the colon of a format string."""
        return format(float(self), spec) if spec else write(float(self), self.form)

    def written_as(self, form: Form) -> Cell:
        """Return the number with another form."""
        return Cell(self, self.source, form, self.draws)

    def __sub__(self, other: object) -> Cell:
        """Subtract another number of the metrics, in every resample as well; the difference names both sources."""
        if not isinstance(other, Cell):
            return NotImplemented
        ours, theirs = (np.array(float(one)) if one.draws is None else one.draws for one in (self, other))
        draws = ours - theirs if self.draws is not None or other.draws is not None else None
        return Cell(float(self) - float(other), f"{self.source} − {other.source}", DIFFERENCE, draws)


def lowest_of(cells: Sequence[Cell]) -> Cell:
    """Return the lowest of several numbers, in every resample as well."""
    return _choose(cells, np.nanmin)


def highest_of(cells: Sequence[Cell]) -> Cell:
    """Return the highest of several numbers, in every resample as well."""
    return _choose(cells, np.nanmax)


def _choose(cells: Sequence[Cell], choose: Callable[..., Any]) -> Cell:
    value = choose([float(cell) for cell in cells])
    known = any(cell.draws is not None for cell in cells)
    length = max((cell.draws.size for cell in cells if cell.draws is not None), default=1)
    columns = [np.full(length, float(cell)) if cell.draws is None else cell.draws for cell in cells]
    draws = choose(np.stack(columns), axis=0) if known else None
    return Cell(value, f"{'least' if choose is np.nanmin else 'greatest'} of {len(cells)}", cells[0].form, draws)


def ratio(numerator: Cell, denominator: Cell) -> Cell:
    """Return a quotient of two numbers, in every resample as well."""
    draws = None if numerator.draws is None or denominator.draws is None else numerator.draws / denominator.draws
    return Cell(float(numerator) / float(denominator), f"{numerator.source} / {denominator.source}", RATE, draws)


def mean_of(cells: Sequence[Cell]) -> Cell:
    """Return the mean of several numbers of one kind, in every resample as well."""
    drawn = [cell.draws for cell in cells if cell.draws is not None]
    draws = np.mean(drawn, axis=0) if len(drawn) == len(cells) else None
    sources = "; ".join(dict.fromkeys(cell.source for cell in cells))
    return Cell(float(np.mean([float(cell) for cell in cells])), f"mean of {sources}", cells[0].form, draws)


@dataclass(frozen=True)
class Sums:
    """Sums over some outcomes by scene, of which resamples of scenes follow.

    totals, sizes: float64 (scenes,). words: what they are of.
    """

    totals: np.ndarray
    sizes: np.ndarray
    split: str
    words: str

    def mean(self, form: Form = RATE) -> Cell:
        """Return the mean of the outcomes. A resample without any of them has NaN."""
        drawn = draw_resamples(len(self.sizes), self.split)
        with np.errstate(invalid="ignore"):
            draws = (drawn @ self.totals) / (drawn @ self.sizes)
        return Cell(self.totals.sum() / self.sizes.sum(), self.words, form, draws)

    def per_scene(self, choose: Callable[..., Any]) -> Cell:
        """Return the lowest (`np.nanmin`) or highest (`np.nanmax`) rate of the scenes with outcomes."""
        with np.errstate(invalid="ignore"):
            rates = self.totals / self.sizes
        drawn = draw_resamples(len(rates), self.split) > 0
        draws = choose(np.where(drawn, rates, np.nan), axis=1)
        word = "lowest" if choose is np.nanmin else "highest"
        return Cell(float(choose(rates)), f"{self.words}, {word} of the scenes", RATE, draws)

    def total(self, form: Form = COUNT) -> Cell:
        """Return the sum of the outcomes."""
        return Cell(self.totals.sum(), self.words, form, draw_resamples(len(self.sizes), self.split) @ self.totals)


class Metrics:
    """The files of results/metrics by their names without ending. arms: by what statements call them (`name_arms`).

    Files of outcomes have the name of their split before their own: "main/static_outcomes".
    """

    def __init__(self, files: Mapping[str, pd.DataFrame], arms: Mapping[str, str]) -> None:
        self._files, self._arms = files, arms
        self._by_arm: dict[tuple[str, str], pd.DataFrame] = {}

    @classmethod
    def load(cls, paths: Iterable[Path], arms: Mapping[str, str]) -> Metrics:
        """Read csv files with a header."""
        files = {f"{path.parent.name}/{path.stem}" if _has_outcomes(path) else path.stem: read_metrics(path) for path in paths}
        return cls(files, arms)

    def outcomes(self, kind: Kind, arm: str, split: str = "main", **where: str | int | tuple[str, ...]) -> pd.DataFrame:
        """Return the outcomes of an arm on a split with the given values, at least one; all relations if none is given.

        Missing: there are none.
        """
        name = f"{split}/{kind}_outcomes"
        frame = self._of_arm(name, self._arm(arm))
        for column, value in where.items():
            if (column, value) != ("relation", ALL):
                frame = frame[frame[column].isin(value if isinstance(value, tuple) else (value,))]
        if frame.empty:
            raise Missing(f"{name}.csv has no row of {', '.join(map(str, (arm, *where.values())))}")
        return frame

    def _of_arm(self, name: str, arm: str) -> pd.DataFrame:
        if (name, arm) not in self._by_arm:
            frame = self.frame(name)
            self._by_arm[name, arm] = frame[frame["arm"] == arm]
        return self._by_arm[name, arm]

    def sums(self, kind: Kind, arm: str, values: pd.Series[Any] | str = "success", split: str = "main", **where: Any) -> Sums:
        """Sum values of the outcomes of an arm by scene. values: a column, or a series with the index of the outcomes."""
        frame = self.outcomes(kind, arm, split, **where)
        column = frame[values] if isinstance(values, str) else values.loc[frame.index]
        of_scene = column.astype(float).groupby(frame["scene"])
        scenes = self._scenes(f"{split}/{kind}_outcomes")
        totals, sizes = (of.reindex(scenes, fill_value=0.0).to_numpy(np.float64) for of in (of_scene.sum(), of_scene.count()))
        words = ", ".join([self._arm(arm), *map(str, where.values())] if where else [self._arm(arm), ALL])
        what = values if isinstance(values, str) else values.name
        return Sums(totals, sizes, split, f"{split}/{kind}_outcomes.csv ({words}): {what}")

    def _scenes(self, name: str) -> list[str]:
        return sorted(self.frame(name)["scene"].unique())

    def frame(self, file: str) -> pd.DataFrame:
        """Return all rows of a file, at least one. Missing: the file is absent or has no rows."""
        if file not in self._files:
            raise Missing(f"there is no {file}.csv")
        if self._files[file].empty:
            raise Missing(f"{file}.csv has no rows")
        return self._files[file]

    def rows(self, file: str, **where: str | int | tuple[str, ...]) -> Rows:
        """Return the rows with the given values, at least one; a tuple means any of its members.

        The relation is "all" if not given. Missing: the row or the arm does not exist.
        """
        frame = self.frame(file)
        if "relation" in frame.columns:
            where.setdefault("relation", ALL)
        words = []
        for column, value in where.items():
            values = value if isinstance(value, tuple) else (self._arm(value) if isinstance(value, str) else value,)
            frame = frame[frame[column].isin(values)]
            words.append(" and ".join(map(str, values)))
        if frame.empty:
            raise Missing(f"{file}.csv has no row of {', '.join(words)}")
        return Rows(file, frame, ", ".join(words))

    def write(self, file: str, column: str = "rate", **where: str | int) -> str:
        """Return the number of a row as text, a dash if it is missing."""
        try:
            return f"{self.rows(file, **where).one(column)}"
        except Missing:
            return EMPTY

    def _arm(self, name: str) -> str:
        name = self._arms.get(name, name)
        if name.startswith(("static.", "embodied.", "controls.")):
            raise Missing(f"sections paper and comparisons.controls of the settings name no arm for {name}")
        return name

    def with_arms(self, others: Mapping[str, str]) -> Metrics:
        """Return the same metrics with other arms in the place of some: both by what statements call them."""
        return Metrics(self._files, {**self._arms, **{name: self._arms.get(other, other) for name, other in others.items()}})


@dataclass(frozen=True)
class Rows:
    """Rows of one file, at least one. words: what they are rows of.

    Every method that reads a number takes a column, or an arithmetic expression of columns, and raises Missing for an empty cell.
    """

    file: str
    frame: pd.DataFrame
    words: str

    def of_seed(self, number: int) -> Rows:
        """Return the rows of one seed, counted from 0."""
        seeds = sorted(self.frame["seed"].unique())
        if number >= len(seeds):
            raise Missing(f"{self.file}.csv has {len(seeds)} of the {number + 1} seeds of {self.words} that are needed")
        return Rows(self.file, self.frame[self.frame["seed"] == seeds[number]], f"{self.words}, seed {seeds[number]}")

    def one(self, column: str = "rate") -> Cell:
        """Return the number of the only row. ValueError if there are several rows."""
        if len(self.frame) > 1:
            raise ValueError(
                f"{self.file}.csv: {len(self.frame)} rows of {self.words}, there must be one; make the metrics again"
            )
        return self._cell(column, self._values(column).iloc[0])

    def mean(self, column: str = "rate") -> Cell:
        """Return the mean over the rows; that of counts is written as an expectation."""
        cell = self._cell(column, self._values(column).mean(), f"mean of {len(self.frame)}")
        return cell.written_as(EXPECTED) if cell.form is COUNT else cell

    def sum(self, column: str) -> Cell:
        """Return the sum over the rows."""
        return self._cell(column, self._values(column).sum(), f"sum of {len(self.frame)}")

    def lowest(self, column: str = "rate") -> Cell:
        """Return the lowest number of the rows."""
        return self._extreme(column, min, "lowest")

    def highest(self, column: str = "rate") -> Cell:
        """Return the highest number of the rows."""
        return self._extreme(column, max, "highest")

    def count_distinct(self, *columns: str) -> Cell:
        """Return how many different values the columns have."""
        number = len(self.frame.drop_duplicates([*columns]))
        return self._cell(", ".join(columns), number, "distinct").written_as(COUNT)

    def lowest_positive(self, column: str, of: str, otherwise: float) -> Cell:
        """Return the lowest number of the rows whose column `of` is above 0; `otherwise` if there are none."""
        chosen = self.frame[self._values(of) > 0]
        words = f"{len(chosen)} of {len(self.frame)} rows with {of} > 0"
        if chosen.empty:
            return self._cell(column, otherwise, words)
        return Rows(self.file, chosen, f"{self.words}, {words}").lowest(column)

    def _cell(self, column: str, value: float, words: str = "") -> Cell:
        words = f"{self.words}, {words}" if words else self.words
        form = _FORMS.get(column, METRES if column.endswith("_m") else RATE)
        return Cell(float(value), f"{self.file}.csv ({words}): {column}", form)

    def _values(self, expression: str) -> pd.Series[float]:
        column: Any = self.frame[expression] if expression in self.frame else self.frame.eval(expression)
        values: pd.Series[float] = pd.Series(column, dtype="float64")
        if values.isna().any():
            raise Missing(f"{self._cell(expression, 0.0).source} is empty")
        return values

    def _extreme(self, column: str, choose: Callable[[pd.Series[float]], float], called: str) -> Cell:
        values = self._values(column)
        row = self.frame.iloc[values.to_list().index(choose(values))]
        which = [f"{name} {row[name]}" for name in _IDENTIFYING if name in row and not pd.isna(row[name]) and row[name] != ""]
        return self._cell(column, choose(values), ", ".join([f"{called} of {len(values)}", *which]))


def _has_outcomes(path: Path) -> bool:
    return path.stem.endswith("_outcomes")


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
