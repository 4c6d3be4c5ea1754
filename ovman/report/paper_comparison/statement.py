"""A statement of the paper: what it claims, the figures that it rests on, and a test that decides whether it holds here."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import Enum, StrEnum

from ovman.report.paper_comparison.metrics import Cell, Metrics, Missing


class Verdict(StrEnum):
    """UNKNOWN: a figure that the test needs is not among the metrics."""

    HOLDS = "holds"
    FAILS = "does not hold"
    UNKNOWN = "cannot be told"


class Form(Enum):
    """How a figure is written: a rate or a difference of rates, a count, a p value, metres, or words for neither."""

    RATE = "rate"
    DIFFERENCE = "difference"
    COUNT = "count"
    EXPECTED = "expected"
    P = "p"
    METRES = "metres"


@dataclass(frozen=True, slots=True)
class Quantity:
    """One figure of a statement. name: what its test calls it. label: what the page calls it. paper: key of the paper's figure.

    read: the figure here; raises Missing where the metrics do not have it. decides: whether the test looks at it; a figure that
    only is shown may be missing.
    """

    name: str
    label: str
    read: Callable[[Metrics], Cell]
    paper: str | None = None
    form: Form = Form.RATE
    decides: bool = True


@dataclass(frozen=True, slots=True)
class Statement:
    """key: stable, names the statement in explanations. claim: the paper's, in our words. rule: the test in words.

    holds: the test, a function of the deciding figures by name, of nothing else.
    """

    key: str
    claim: str
    quantities: tuple[Quantity, ...]
    rule: str
    holds: Callable[[Mapping[str, float]], bool]

    def __post_init__(self) -> None:
        names = [quantity.name for quantity in self.quantities]
        if len(set(names)) < len(names):
            raise ValueError(f"statement {self.key}: two figures have one name")


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement with its figures here (those that there are, by name) and the verdict; missing: what could not be found."""

    statement: Statement
    verdict: Verdict
    cells: Mapping[str, Cell] = field(default_factory=dict)
    missing: str | None = None


def judged(statement: Statement, metrics: Metrics) -> Judgement:
    """The verdict on a statement. Raises ValueError only for metrics that contradict themselves."""
    cells: dict[str, Cell] = {}
    missing = None
    for quantity in statement.quantities:
        try:
            cells[quantity.name] = quantity.read(metrics)
        except Missing as error:
            if quantity.decides and missing is None:
                missing = str(error)
    if missing is not None:
        return Judgement(statement, Verdict.UNKNOWN, cells, missing)
    deciding = {quantity.name: cells[quantity.name].value for quantity in statement.quantities if quantity.decides}
    return Judgement(statement, Verdict.HOLDS if statement.holds(deciding) else Verdict.FAILS, cells)
