"""A statement about the paper: what it claims, and a function that says by how much it holds here.

The function asks `Evidence` for numbers of the metrics and returns margins: differences that the claim says are above 0. Numbers
that it uses or shows appear on the page, in this order, with the paper's next to them. A bootstrap over scenes says how often all
margins are above 0, which gives the verdict. No bound is ours: a claim of the paper is a direction, or has the paper's own bound.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from enum import StrEnum
from typing import Any

import numpy as np
import pandas as pd
from scipy.stats import binom, norm

from ovman.analysis.statistics import RESAMPLES
from ovman.report.metrics import Cell, Metrics, Missing, Rows, Sums, mean_of
from ovman.report.paper import PAPER, RATE, Form, P
from ovman.report.tables.columns import RELATIONS
from ovman.report.tables.table import ALL
from ovman.seeds import generator
from ovman.settings import Kind

SURE = 0.9
"""Share of the resamples in which a claim must hold, or fail, for a verdict."""
SIGNIFICANT = 0.05
"""Level of a claim about significance: the one that the paper's corrected p-values are read at."""
SLACK = 1e-9
"""Rounding that equal numbers may differ by."""


class Verdict(StrEnum):
    """The verdicts on a claim.

    FAILS: the opposite holds. UNDECIDED: the scenes give neither side the share SURE. SOME: the readings of a definition differ.
    UNKNOWN: the metrics lack a figure.
    """

    HOLDS = "holds"
    FAILS = "does not hold"
    UNDECIDED = "undecided"
    SOME = "depends on the reading"
    UNKNOWN = "cannot be told"


HOLDS, FAILS, UNDECIDED, SOME, UNKNOWN = Verdict


@dataclass(frozen=True, slots=True)
class Margin:
    """A claim that a number is above 0, or at least 0 if it is not strict. shown: what pages show, if not the number itself."""

    by: Cell
    strict: bool = True
    shown: Cell | None = None

    @property
    def holds(self) -> bool:
        """Whether the claim holds for the number itself."""
        return bool(self._test(np.float64(self.by)))

    @property
    def draws(self) -> np.ndarray | None:
        """Whether it holds in each resample, bool (RESAMPLES,); None without a record by scene."""
        return None if self.by.draws is None else self._test(self.by.draws)

    def _test(self, values: Any) -> Any:
        return values > SLACK if self.strict else values >= -SLACK


def above(high: Cell, low: Cell | float) -> Margin:
    """Claim that one number is above another."""
    return Margin(high - _as_cell(low))


def at_least(high: Cell, low: Cell | float) -> Margin:
    """Claim that one number is at least another."""
    return Margin(high - _as_cell(low), strict=False)


def is_significant(p: Cell) -> Margin:
    """Claim that a p-value is below SIGNIFICANT."""
    return Margin(_as_cell(SIGNIFICANT) - p, shown=p)


def is_not_significant(p: Cell) -> Margin:
    """Claim that a p-value is not below SIGNIFICANT."""
    return Margin(p - _as_cell(SIGNIFICANT), strict=False, shown=p)


def _as_cell(number: Cell | float) -> Cell:
    return number if isinstance(number, Cell) else Cell(number, f"{number:g}")


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure on the page. paper: key of the paper's figure; decides: whether the verdict depends on it."""

    label: str
    cell: Cell
    paper: str
    decides: bool


@dataclass(frozen=True, slots=True)
class Explanation:
    """A note written by hand, one paragraph of Markdown. It is a conjecture unless a measurement of the cause backs it.

    verdict, under: The verdict that it explains; `under` are the readings under which the statement holds, where they differ.
    measured: Numbers that measure the cause. A figure that the verdict depends on measures the effect and is refused.
    given: Whether the figures are as the text supposes.
    """

    verdict: Verdict
    text: str
    measured: tuple[Cell, ...] = ()
    given: bool = True
    under: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Measured or conjecture."""
        return "measured" if self.measured else "conjecture"


@dataclass(frozen=True, slots=True)
class Other:
    """Another reading of a definition.

    arms: Arms that are read instead, by those that they replace. holds_if: Another test in words; the function looks at
    `Evidence.reading`.
    """

    arms: Mapping[str, str] = field(default_factory=dict)
    holds_if: str = ""


@dataclass(frozen=True, slots=True)
class Readings:
    """The readings of a definition that the paper leaves open. own: the one that the figures in the table are of."""

    definition: str
    own: str
    others: Mapping[str, Other]


class Evidence:
    """The numbers that the function of a statement asks for.

    Attributes:
        metrics: All of them. `rows` reads single ones.
        figures: Those on the page.
        explanation: The explanation, if the function has one.
        reading: Name of the reading of the definition; empty for a statement without several.
    """

    def __init__(self, metrics: Metrics, reading: str = "", *, about_paper: bool = True) -> None:
        self.metrics, self.rows, self._about_paper = metrics, metrics.rows, about_paper
        self.reading = reading
        self.figures: list[Figure] = []
        self.explanation: Explanation | None = None

    def rate(self, kind: Kind, arm: str, relation: str | tuple[str, ...] = ALL, split: str = "main", **where: Any) -> Cell:
        """Return the success rate of an arm; of several relations the mean of their rates."""
        if isinstance(relation, tuple):
            return mean_of([self.rate(kind, arm, one, split, **where) for one in relation])
        return self.metrics.sums(kind, arm, split=split, relation=relation, **where).mean()

    def static(self, row: str, relation: str | tuple[str, ...] = ALL) -> Cell:
        """Return the success on the static gate of the arm next to a row of the paper's Table "static"."""
        return self.rate(Kind.STATIC, f"static.{row}", relation)

    def embodied(self, row: str, relation: str | tuple[str, ...] = ALL, **where: Any) -> Cell:
        """Return the success when navigating of the arm next to a row of the paper's Table "embodied"."""
        return self.rate(Kind.EMBODIED, f"embodied.{row}", relation, **where)

    def significance(self, arm: str, baseline: str, relation: str = ALL) -> Rows:
        """Return the rows of an exact test of two arms, one per seed."""
        return self.rows("significance", arm=arm, baseline=baseline, relation=relation)

    def seeds(self, arm: str, number: int, kind: Kind = Kind.EMBODIED) -> list[int]:
        """Return the seeds, or runs, of an arm. Missing: there are fewer than `number`."""
        seeds = sorted(self.metrics.outcomes(kind, arm)["seed"].unique())
        if len(seeds) < number:
            raise Missing(f"{kind}_outcomes.csv has {len(seeds)} of the {number} seeds of {arm} that are needed")
        return seeds

    def share(self, rows: Rows, count: str, of: str) -> Cell:
        """Return the share of a count without a record by scene; its draws are of Jeffreys' posterior, not of scenes."""
        hits, n = rows.one(count), rows.one(of)
        draws = generator(0, "share", hits.source).beta(hits + 0.5, n - hits + 0.5, RESAMPLES)
        return Cell(hits / n, f"{hits.source} / {of}", RATE, draws)

    def p(self, kind: Kind, arm: str, baseline: str, relation: str = ALL, exact: Cell | None = None) -> Cell:
        """Return the exact p of two arms under their first seed; of a relation the one corrected for all six.

        exact: The p, if it is not in significance.csv.
        """
        if exact is None:
            rows = self.rows("significance", arm=arm, baseline=baseline, relation=relation).of_seed(0)
            exact = rows.one("p" if relation == ALL else "p_holm")
        of = [relation] if relation == ALL else [one for one in RELATIONS if self._has(kind, arm, one)]
        drawn = np.column_stack([self._draw_p(kind, arm, baseline, one) for one in of])
        corrected = drawn if relation == ALL else _correct(drawn)
        return Cell(exact, exact.source, P, corrected[:, of.index(relation)])

    def _has(self, kind: Kind, arm: str, relation: str) -> bool:
        return bool((self.metrics.outcomes(kind, arm)["relation"] == relation).any())

    def _draw_p(self, kind: Kind, arm: str, baseline: str, relation: str) -> np.ndarray:
        """Return the p of two arms in each resample; against a stochastic pick by the normal approximation."""
        ours, theirs = (self._first_seed(kind, one, relation) for one in (arm, baseline))
        theirs = theirs.reindex(ours.index)

        def total(values: pd.Series[float]) -> np.ndarray:
            draws = self._sum(kind, arm, values, relation).total().draws
            assert draws is not None
            return draws

        if theirs.isin((0.0, 1.0)).all():
            wins, losses = total((ours - theirs).clip(lower=0)), total((theirs - ours).clip(lower=0))
            fewest: np.ndarray = np.minimum(1.0, 2.0 * binom.cdf(np.minimum(wins, losses), wins + losses, 0.5))
            return fewest
        expected, variance = total(theirs), total(theirs * (1.0 - theirs))
        tail: np.ndarray = norm.sf((total(ours) - 0.5 - expected) / np.sqrt(np.maximum(variance, SLACK)))
        return tail

    def _first_seed(self, kind: Kind, arm: str, relation: str) -> pd.Series[float]:
        frame = self.metrics.outcomes(kind, arm, relation=relation)
        series: pd.Series[float] = frame[frame["seed"] == frame["seed"].min()].set_index("episode")["success"]
        return series

    def _sum(self, kind: Kind, arm: str, values: pd.Series[float], relation: str) -> Sums:
        frame = self.metrics.outcomes(kind, arm, relation=relation)
        first = frame["seed"].min()
        by_row = frame["episode"].map(values).where(frame["seed"] == first, 0.0).rename("success")
        return self.metrics.sums(kind, arm, by_row, relation=relation)

    def use(self, label: str, cell: Cell, paper: str = "", *, decides: bool = True) -> Cell:
        """Show a number next to the paper's figure of this key. decides: Whether the verdict depends on it."""
        self.figures.append(Figure(label, cell, paper if self._about_paper else "", decides))
        return cell

    def show(self, label: str, cell: Cell, paper: str = "") -> Cell:
        """Show a number on which the verdict does not depend."""
        return self.use(label, cell, paper, decides=False)

    def use_static(self, label: str, row: str, relation: str = "all", *, decides: bool = True) -> Cell:
        """Show a rate on the static gate, next to the paper's."""
        return self.use(label, self.static(row, relation), f"static.{row}.{relation}", decides=decides)

    def use_embodied(self, label: str, row: str, relation: str = "all", *, decides: bool = True) -> Cell:
        """Show a rate when navigating, next to the paper's."""
        return self.use(label, self.embodied(row, relation), f"embodied.{row}.{relation}", decides=decides)

    def quote(self, key: str, form: Form = RATE) -> str:
        """Return a figure of the paper as text."""
        return PAPER[key].write(form)


def _correct(p: np.ndarray) -> np.ndarray:
    """Return Holm's correction of the p-values of each row (draws, relations)."""
    order, count = np.argsort(p, axis=1), p.shape[1]
    steps = np.take_along_axis(p, order, axis=1) * np.arange(count, 0, -1)
    corrected = np.empty_like(p)
    np.put_along_axis(corrected, order, np.minimum(np.maximum.accumulate(steps, axis=1), 1.0), axis=1)
    return corrected


Test = Callable[[Evidence], "Margin | Sequence[Margin]"]


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement. claim: in our words; holds_if: the test in words, which completes "holds if ..."."""

    key: str
    claim: str
    holds_if: str
    test: Test
    about_paper: bool
    readings: Readings | None = None
    is_listed: bool = False

    @property
    def name(self) -> str:
        """The key in words, by which pages call the statement."""
        return self.key.replace("_", " ")


@dataclass(frozen=True, slots=True)
class Group:
    """The statements under one heading of the page. about_paper: whether the paper makes them; the others are our own."""

    title: str
    about_paper: bool = True
    statements: list[Statement] = field(default_factory=list)

    def statement(
        self, claim: str, holds_if: str, readings: Readings | None = None, *, listed: bool = False
    ) -> Callable[[Test], Statement]:
        """Add the statement that a function decides; the function's name is its key. listed: on the page of results, too."""

        def add(test: Test) -> Statement:
            self.statements.append(Statement(test.__name__, claim, holds_if, test, self.about_paper, readings, listed))
            return self.statements[-1]

        return add


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement with its figures here and the verdict.

    missing: The first figure that the metrics lack, in one line. margins: The differences that the claim says are above 0.
    share: Of the resamples of scenes, those in which the claim holds; None without a record by scene. readings: For a statement
    with several readings, the judgement under each, its own first.
    """

    statement: Statement
    verdict: Verdict
    evidence: Evidence
    missing: str = ""
    margins: tuple[Margin, ...] = ()
    share: float | None = None
    readings: Mapping[str, Judgement] = field(default_factory=dict)

    def under(self, verdict: Verdict) -> tuple[str, ...]:
        """Return the names of the readings with a verdict."""
        return tuple(name for name, reading in self.readings.items() if reading.verdict is verdict)

    @property
    def narrowest(self) -> Margin | None:
        """The margin that holds in the fewest resamples, of equal ones the smallest."""
        return min(self.margins, key=lambda one: (_share([one], float(one.holds)), float(one.by)), default=None)


def judge(statement: Statement, metrics: Metrics) -> Judgement:
    """Decide whether a statement holds under all readings, none or some.

    Without a verdict under its own reading there is none; without one under another reading that reading is left out. Readings of
    which one holds and another does not give SOME; other differences leave the statement undecided.
    """
    readings = statement.readings
    if readings is None:
        return _judge(statement, metrics)
    judgements = {readings.own: _judge(statement, metrics, readings.own)}
    for name, other in readings.others.items():
        judgements[name] = _judge(statement, metrics.with_arms(other.arms), name)
    own = judgements[readings.own]
    known = {judgement.verdict for judgement in judgements.values()} - {UNKNOWN}
    verdict = own.verdict
    if verdict is not UNKNOWN and len(known) > 1:
        verdict = SOME if {HOLDS, FAILS} <= known else UNDECIDED
    return replace(own, verdict=verdict, readings=judgements)


def _judge(statement: Statement, metrics: Metrics, reading: str = "") -> Judgement:
    evidence = Evidence(metrics, reading, about_paper=statement.about_paper)
    try:
        claimed = statement.test(evidence)
    except Missing as missing:
        return Judgement(statement, UNKNOWN, evidence, str(missing))
    margins = (claimed,) if isinstance(claimed, Margin) else tuple(claimed)
    _check_cause(statement, evidence)
    share = _share(margins)
    sure = float(all(one.holds for one in margins)) if share is None else share
    verdict = HOLDS if sure >= SURE - SLACK else FAILS if sure <= 1.0 - SURE + SLACK else UNDECIDED
    return Judgement(statement, verdict, evidence, margins=margins, share=share)


def _share(margins: Sequence[Margin], otherwise: float | None = None) -> Any:
    """Return the share of the resamples in which all margins hold; `otherwise` without a record by scene."""
    drawn = [one.draws for one in margins if one.draws is not None]
    if not drawn:
        return otherwise
    fixed = all(one.holds for one in margins if one.draws is None)
    return float(np.all(drawn, axis=0).mean()) * fixed


def _check_cause(statement: Statement, evidence: Evidence) -> None:
    """Refuse an explanation that passes figures of the verdict off as a measurement of its cause."""
    deciding = {figure.cell.source for figure in evidence.figures if figure.decides}
    for cell in evidence.explanation.measured if evidence.explanation else ():
        if cell.source in deciding or not cell.source:
            raise ValueError(
                f"{statement.key}: {cell.source or 'a number without a source'} does not measure the cause; "
                "name a measurement of the cause, or leave the explanation a conjecture"
            )


def explain(judgement: Judgement) -> str | None:
    """Return the note below a verdict, one paragraph of Markdown; None for a verdict that needs none.

    An explanation of another verdict, or of other figures, is left out, which a line says. A statement that does not hold under
    every reading and has no explanation gets such a line, too.
    """
    explanation = judgement.evidence.explanation
    if explanation is None:
        return "No explanation yet." if judgement.verdict in (FAILS, SOME) else None
    now = _describe(judgement.verdict, judgement.under(HOLDS))
    if (then := _describe(explanation.verdict, explanation.under)) != now:
        if judgement.verdict not in (FAILS, SOME):
            return None
        return f"The explanation at hand is of the verdict “{then}”, so it is left out."
    if not explanation.given:
        return "The explanation at hand supposes figures that these metrics do not show, so it is left out."
    return f"{' '.join(explanation.text.split())} *({explanation.label.capitalize()}.)*"


def _describe(verdict: Verdict, under: Iterable[str]) -> str:
    return f"{verdict}: {', '.join(sorted(under))}" if verdict is SOME else str(verdict)
