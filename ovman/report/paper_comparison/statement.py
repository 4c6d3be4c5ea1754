"""A statement of the paper: what it claims, the figures that it rests on, and a test that decides whether it holds here."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from enum import StrEnum
from functools import cache
from pathlib import Path
from typing import Annotated, Self

import yaml
from jinja2 import StrictUndefined, TemplateSyntaxError, meta
from jinja2.environment import TemplateExpression
from jinja2.sandbox import SandboxedEnvironment
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from ovman.report.paper_comparison.metrics import Cell, Metrics, Missing, Reading

STATEMENTS = Path(__file__).with_name("statements.yaml")
_EXPRESSIONS = SandboxedEnvironment(undefined=StrictUndefined)


class Verdict(StrEnum):
    """SOME: it holds under one reading of a definition, not under another. UNKNOWN: a figure that the test needs is missing."""

    HOLDS = "holds"
    FAILS = "does not hold"
    SOME = "holds under some readings only"
    UNKNOWN = "cannot be told"


class Form(StrEnum):
    """How a figure is written: a rate or a difference of rates, a count, the expectation of one, a p value, or metres."""

    RATE = "rate"
    DIFFERENCE = "difference"
    COUNT = "count"
    EXPECTED = "expected"
    P = "p"
    METRES = "metres"


@cache
def _compiled(text: str) -> TemplateExpression:
    return _EXPRESSIONS.compile_expression(text, undefined_to_none=False)


def expression(text: str) -> str:
    """The text of an expression over figures. Raises ValueError for one that cannot be parsed."""
    try:
        _compiled(text)
    except TemplateSyntaxError as error:
        raise ValueError(f"{text!r} is no expression: {error.message}") from None
    return text


class Quantity(BaseModel):
    """One figure of a statement: a number of the metrics (`read`) or an expression over the figures before it (`of`).

    label: what the page calls it. paper: key of the paper's figure. decides: whether the test looks at it; a figure that is only
    shown may be missing.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    label: Annotated[str, Field(min_length=1)]
    read: Reading | None = None
    of: str | None = None
    paper: str | None = None
    form: Form = Form.RATE
    decides: bool = True

    @model_validator(mode="after")
    def _one_of_two(self) -> Self:
        if (self.read is None) == (self.of is None):
            raise ValueError("a figure has either read or of")
        if self.of is not None:
            expression(self.of)
        return self


class Other(BaseModel):
    """Another reading of a definition.

    arms: rows of the arms that are read instead, by the rows that they take the place of. rule, holds: another test; the
    statement's if not given.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    arms: Mapping[str, str] = {}
    rule: str | None = None
    holds: str | None = None

    @model_validator(mode="after")
    def _another(self) -> Self:
        if (self.rule is None) != (self.holds is None):
            raise ValueError("another test has both rule and holds")
        if not self.arms and self.holds is None:
            raise ValueError("another reading has other arms or another test")
        if self.holds is not None:
            expression(self.holds)
        return self


class Readings(BaseModel):
    """definition: what the paper's text leaves open. own: the reading that the statement's figures are of. others: by name."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    definition: Annotated[str, Field(min_length=1)]
    own: Annotated[str, Field(min_length=1)]
    others: Annotated[Mapping[str, Other], Field(min_length=1)]

    @model_validator(mode="after")
    def _names(self) -> Self:
        if self.own in self.others:
            raise ValueError(f"{self.own} is the name of two readings")
        return self


class Statement(BaseModel):
    """claim: the paper's, in our words. rule: the test in words. holds: the test, an expression over the deciding figures.

    readings: where the claim depends on a definition that can be read in several ways.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    key: Annotated[str, Field(min_length=1)]
    claim: Annotated[str, Field(min_length=1)]
    figures: Mapping[str, Quantity]
    rule: Annotated[str, Field(min_length=1)]
    holds: str
    readings: Readings | None = None

    @model_validator(mode="after")
    def _test(self) -> Self:
        expression(self.holds)
        return self

    def under(self, other: Other) -> Statement:
        """The statement under another reading, which has no readings itself."""
        figures = {
            name: quantity.model_copy(update={"read": quantity.read and quantity.read.of_arms(other.arms)})
            for name, quantity in self.figures.items()
        }
        test = {"rule": other.rule or self.rule, "holds": other.holds or self.holds}
        return self.model_copy(update={"figures": figures, "readings": None, **test})


class Group(BaseModel):
    """Statements under one heading of the page."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    title: str
    statements: tuple[Statement, ...]

    @model_validator(mode="before")
    @classmethod
    def _keyed(cls, value: dict[str, object]) -> dict[str, object]:
        by_key = value.get("statements")
        if not isinstance(by_key, dict):
            return value
        return {**value, "statements": [{**entry, "key": key} for key, entry in by_key.items()]}


def read(path: Path = STATEMENTS) -> tuple[Group, ...]:
    """The statements, in the order of the page. Raises ValueError in one line that names the file and the key."""
    try:
        return _parsed(path.read_text(encoding="utf-8"))
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None


@cache
def _parsed(text: str) -> tuple[Group, ...]:
    return TypeAdapter(tuple[Group, ...]).validate_python(yaml.safe_load(text))


def every(groups: Iterable[Group]) -> tuple[Statement, ...]:
    """The statements of all groups, in order; the page numbers them from 1."""
    return tuple(statement for group in groups for statement in group.statements)


@dataclass(frozen=True, slots=True)
class Judgement:
    """A statement with its figures here (those that were found, by name) and the verdict; missing: what could not be found.

    readings: of a statement with several, what comes of each, by name, its own first.
    """

    statement: Statement
    verdict: Verdict
    cells: Mapping[str, Cell] = field(default_factory=dict)
    missing: str | None = None
    readings: Mapping[str, Judgement] = field(default_factory=dict)

    def under(self, verdict: Verdict) -> tuple[str, ...]:
        """The names of the readings with a verdict."""
        return tuple(name for name, reading in self.readings.items() if reading.verdict is verdict)


def judged(statement: Statement, metrics: Metrics) -> Judgement:
    """The verdict on a statement. Raises ValueError only for metrics that contradict themselves.

    Where its own reading cannot be told, nothing can; where another cannot, the verdict is that of the others.
    """
    own = _judged(statement, metrics)
    if statement.readings is None:
        return own
    others = {name: _judged(statement.under(other), metrics) for name, other in statement.readings.others.items()}
    readings = {statement.readings.own: own, **others}
    told = {reading.verdict for reading in readings.values()} - {Verdict.UNKNOWN}
    differ = own.verdict is not Verdict.UNKNOWN and len(told) > 1
    return replace(own, verdict=Verdict.SOME if differ else own.verdict, readings=readings)


def _judged(statement: Statement, metrics: Metrics) -> Judgement:
    cells: dict[str, Cell] = {}
    missing = None
    for name, quantity in statement.figures.items():
        try:
            cells[name] = figure(quantity, cells, metrics)
        except Missing as error:
            if quantity.decides and missing is None:
                missing = str(error)
    if missing is not None:
        return Judgement(statement, Verdict.UNKNOWN, cells, missing)
    deciding = {name: cells[name].value for name, quantity in statement.figures.items() if quantity.decides}
    holds = _compiled(statement.holds)(**deciding)
    return Judgement(statement, Verdict.HOLDS if holds else Verdict.FAILS, cells)


def figure(quantity: Quantity, cells: Mapping[str, Cell], metrics: Metrics) -> Cell:
    """The number of a quantity; cells: those that an expression may name. Raises Missing where it cannot be known."""
    if quantity.read is not None:
        return metrics.read(quantity.read)
    values = {name: cell.value for name, cell in cells.items()}
    text = quantity.of or ""
    if absent := [name for name in names(text) if name not in values]:
        raise Missing(f"{absent[0]} is not known")
    return Cell(float(_compiled(text)(**values) or 0.0), text)


def true(expression: str, cells: Mapping[str, Cell]) -> bool:
    """Whether an expression over figures is true of them."""
    return bool(_compiled(expression)(**{name: cell.value for name, cell in cells.items()}))


def names(text: str) -> list[str]:
    """The figures that an expression names."""
    return sorted(meta.find_undeclared_variables(_EXPRESSIONS.parse(f"{{{{ {text} }}}}")))
