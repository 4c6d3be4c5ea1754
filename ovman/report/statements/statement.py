"""A statement about the paper: what it claims, and a function that decides whether it holds here.

The function asks `Evidence` for numbers of the metrics. Those that it uses or shows appear on the page, in this order, with the
paper's next to them. It may explain a verdict: the explanation appears only below the verdict that it was written for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum

from ovman.report.metrics import Cell, Metrics, Missing, Rows
from ovman.report.paper import PAPER, RATE, Form


class Verdict(StrEnum):
    """SOME: it holds under one reading of a definition, not under another. UNKNOWN: the metrics lack a figure."""

    HOLDS = "holds"
    FAILS = "does not hold"
    SOME = "holds under some readings only"
    UNKNOWN = "cannot be told"


HOLDS, FAILS, SOME, UNKNOWN = Verdict


@dataclass(frozen=True, slots=True)
class Figure:
    """One figure on the page. paper: key of the paper's figure; decides: whether the verdict depends on it."""

    label: str
    cell: Cell
    paper: str
    decides: bool


@dataclass(frozen=True, slots=True)
class Explanation:
    """A note written by hand, one paragraph of Markdown.

    verdict, under: What it explains; `under` are the readings under which the statement holds, where it holds under some only.
    given: Whether the figures are as the text supposes. episodes: Those whose frames were inspected.
    """

    verdict: Verdict
    text: str
    given: bool = True
    under: tuple[str, ...] = ()
    episodes: tuple[str, ...] = ()


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
        figures: Those on the page.
        explanation: The explanation, if the function has one.
        reading: Name of the reading of the definition; empty for a statement without several.
    """

    def __init__(self, metrics: Metrics, numbers: Mapping[str, int], reading: str = "", *, about_paper: bool = True) -> None:
        self.rows = metrics.rows
        self._numbers, self._about_paper = numbers, about_paper
        self.reading = reading
        self.figures: list[Figure] = []
        self.explanation: Explanation | None = None

    def static(self, row: str, relation: str | tuple[str, ...] = "all") -> Rows:
        """Return the rows of success on the static gate of the arm next to a row of the paper's Table "static"."""
        return self.rows("static_rates", arm=f"static.{row}", relation=relation)

    def embodied(self, row: str, relation: str = "all") -> Rows:
        """Return the rows of success when navigating of the arm next to a row of the paper's Table "embodied"."""
        return self.rows("embodied_rates", arm=f"embodied.{row}", relation=relation)

    def significance(self, arm: str, baseline: str, relation: str = "all") -> Rows:
        """Return the rows of an exact test of two arms, one per seed."""
        return self.rows("significance", arm=arm, baseline=baseline, relation=relation)

    def use(self, label: str, cell: Cell, paper: str = "", *, decides: bool = True) -> Cell:
        """Show a number next to the paper's figure of this key. decides: Whether the verdict depends on it."""
        self.figures.append(Figure(label, cell, paper if self._about_paper else "", decides))
        return cell

    def show(self, label: str, cell: Cell, paper: str = "") -> Cell:
        """Show a number on which the verdict does not depend."""
        return self.use(label, cell, paper, decides=False)

    def use_static(self, label: str, row: str, relation: str = "all", *, decides: bool = True) -> Cell:
        """Show a rate on the static gate, next to the paper's."""
        return self.use(label, self.static(row, relation).one(), f"static.{row}.{relation}", decides=decides)

    def use_embodied(self, label: str, row: str, relation: str = "all", *, decides: bool = True) -> Cell:
        """Show a rate when navigating, next to the paper's."""
        return self.use(label, self.embodied(row, relation).one(), f"embodied.{row}.{relation}", decides=decides)

    def quote(self, key: str, form: Form = RATE) -> str:
        """Return a figure of the paper as text."""
        return PAPER[key].write(form)

    def number(self, key: str) -> int:
        """Return the number of another statement on the page."""
        return self._numbers[key]


Test = Callable[[Evidence], bool]


@dataclass(frozen=True, slots=True)
class Statement:
    """One statement. claim: in our words; holds_if: the test in words, which completes "holds if ..."."""

    key: str
    claim: str
    holds_if: str
    test: Test
    about_paper: bool
    readings: Readings | None = None


@dataclass(frozen=True, slots=True)
class Group:
    """The statements under one heading of the page. about_paper: whether the paper makes them; the others are our own."""

    title: str
    about_paper: bool = True
    statements: list[Statement] = field(default_factory=list)

    def statement(self, claim: str, holds_if: str, readings: Readings | None = None) -> Callable[[Test], Statement]:
        """Add the statement that a function decides; the function's name is its key."""

        def add(test: Test) -> Statement:
            self.statements.append(Statement(test.__name__, claim, holds_if, test, self.about_paper, readings))
            return self.statements[-1]

        return add


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement with its figures here and the verdict.

    missing: The first figure that the metrics lack, in one line. readings: For a statement with several readings, the judgement
    under each, its own first.
    """

    statement: Statement
    verdict: Verdict
    evidence: Evidence
    missing: str = ""
    readings: Mapping[str, Judgement] = field(default_factory=dict)

    def under(self, verdict: Verdict) -> tuple[str, ...]:
        """Return the names of the readings with a verdict."""
        return tuple(name for name, reading in self.readings.items() if reading.verdict is verdict)


def judge(statement: Statement, metrics: Metrics, numbers: Mapping[str, int]) -> Judgement:
    """Decide whether a statement holds under all readings, none or some. numbers: of all statements by key.

    Without a verdict under its own reading there is none; without one under another reading that reading is left out.
    """
    readings = statement.readings
    if readings is None:
        return _judge(statement, metrics, numbers)
    judgements = {readings.own: _judge(statement, metrics, numbers, readings.own)}
    for name, other in readings.others.items():
        judgements[name] = _judge(statement, metrics.with_arms(other.arms), numbers, name)
    own = judgements[readings.own]
    known = {judgement.verdict for judgement in judgements.values()} - {UNKNOWN}
    differ = own.verdict is not UNKNOWN and len(known) > 1
    return replace(own, verdict=SOME if differ else own.verdict, readings=judgements)


def _judge(statement: Statement, metrics: Metrics, numbers: Mapping[str, int], reading: str = "") -> Judgement:
    evidence = Evidence(metrics, numbers, reading, about_paper=statement.about_paper)
    try:
        return Judgement(statement, HOLDS if statement.test(evidence) else FAILS, evidence)
    except Missing as missing:
        return Judgement(statement, UNKNOWN, evidence, str(missing))


def explain(judgement: Judgement) -> str | None:
    """Return the note below a verdict, one paragraph of Markdown; None for a verdict that needs none.

    An explanation of another verdict, or of other figures, is replaced by a warning. A statement that does not hold under every
    reading and has no explanation gets a warning, too.
    """
    explanation = judgement.evidence.explanation
    if explanation is None:
        return "No explanation yet: the frames have not been inspected." if judgement.verdict in (FAILS, SOME) else None
    now = _describe(judgement.verdict, judgement.under(HOLDS))
    if (then := _describe(explanation.verdict, explanation.under)) != now:
        return (
            f"⚠ The explanation at hand was written when the verdict was “{then}”. "
            f"Now it is “{now}”, so the explanation is left out until it is reviewed."
        )
    if not explanation.given:
        return "⚠ The explanation at hand supposes figures that these metrics do not show, so it is left out."
    episodes = ", ".join(f"`{episode}`" for episode in explanation.episodes)
    text = " ".join(explanation.text.split())
    return f"{text}{f' (Looked at: {episodes}.)' if episodes else ''} *Written by hand.*"


def _describe(verdict: Verdict, under: Iterable[str]) -> str:
    return f"{verdict}: {', '.join(sorted(under))}" if verdict is SOME else str(verdict)
