"""The tables of the page: ours beside the paper's, a row each, and what could not be found left empty."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ovman.analysis.language import What
from ovman.report.markdown import pipe_table
from ovman.report.paper_comparison import sources
from ovman.report.paper_comparison.baselines import COW
from ovman.report.paper_comparison.budget import GROUNDING, ORACLE, ORACLE_POSITIONS, POSITIONS
from ovman.report.paper_comparison.memory import ONE, ONE_EMBODIED, TWO, TWO_EMBODIED
from ovman.report.paper_comparison.metrics import Cell, Metrics, Missing
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.sources import ALL, RELATIONS, Read
from ovman.report.paper_comparison.statement import Form
from ovman.report.paper_comparison.writing import EMPTY, papers, written

HERE, PAPER = "here", "paper"


@dataclass(frozen=True, slots=True)
class Line:
    """One row of ours and one of the paper's. title: of both; row: the paper's, "static.two_visits"; columns: their keys.

    read: the figure of ours for a column. optional: shown only where the metrics have something of it, as of a released system.
    """

    title: str
    row: str
    columns: tuple[str, ...]
    read: Callable[[str], Read]
    form: Form = Form.RATE
    optional: bool = False


_EVERY = (*RELATIONS, ALL)
_HEADS = tuple(column.upper() for column in _EVERY)


def _static(title: str, arm: str, row: str | None = None) -> Line:
    read = lambda relation: sources.static(arm, relation)  # noqa: E731
    return Line(title, f"static.{row or arm}", _EVERY, read, optional=row is not None)


def _embodied(title: str, arm: str, row: str | None = None) -> Line:
    def read(column: str) -> Read:
        return sources.embodied(arm, ALL, "spl") if column == "spl" else sources.embodied(arm, column)

    return Line(title, f"embodied.{row or arm}", (*_EVERY, "spl"), read, optional=row is not None)


def _dualmap(handed: str, words: str) -> tuple[Line, ...]:
    """DualMap's two readings: ours of it, and the released system beside the same rows of the paper."""
    return tuple(
        line
        for reading, memory in (("maintained", "maintained map"), ("two_visits", "two visits"))
        for row in (f"{handed}dualmap_{reading}",)
        for line in (
            _static(f"dualmap (reimplemented), {memory}{words}", row),
            _static(f"DualMap (released), {memory}{words}", f"{handed}dualmap_released_{reading}", row),
        )
    )


STATIC = (
    _static("one visit", ONE),
    *_dualmap("", ""),
    _static("two visits", TWO),
    *_dualmap("grounding_", ", grounding handed over"),
    _static("one visit, grounding handed over", f"grounding_{ONE}"),
    _static("two visits, grounding handed over", GROUNDING),
    _static("one visit, positions handed over", f"positions_{ONE}"),
    _static("two visits, positions handed over", POSITIONS),
)
EMBODIED = (
    _embodied("cow (reimplemented)", COW),
    _embodied("CoW (released)", f"{COW}_released", COW),
    _embodied("cow (reimplemented), 500 actions", f"{COW}_500", f"{COW}_500"),
    _embodied("one visit", ONE_EMBODIED),
    _embodied("two visits", TWO_EMBODIED),
    _embodied("two visits, true positions", ORACLE_POSITIONS),
    _embodied("oracle", ORACLE),
)
TAXONOMY = tuple(
    Line(title, f"taxonomy.{key}", _EVERY, lambda relation, key=key: sources.outcomes(key, relation), Form.COUNT)
    for key, title in (
        ("success", "success"),
        ("abstain", "abstained (no candidate)"),
        ("elsewhere", "elsewhere (> 2 m)"),
        ("near_miss", "near miss (1–2 m)"),
        ("wrong_instance", "wrong instance"),
        ("episodes", "episodes"),
        ("lost_in_navigation", "lost in navigation, first seed †"),
    )
)
LINES = {"static": STATIC, "embodied": EMBODIED, "taxonomy": TAXONOMY}
_INTERVALS = (
    ("one visit", ONE_EMBODIED, "embodied_interval_single_visit"),
    ("two visits", TWO_EMBODIED, "embodied_interval_two_visits"),
    ("two visits, true positions", ORACLE_POSITIONS, "embodied_interval_oracle_positions"),
)
_NUMBERS_OF_INSTANCES = (
    ("two", sources.TWO_INSTANCES, "two"),
    ("three", sources.THREE_INSTANCES, "three"),
    ("four or more", sources.MORE_INSTANCES, "more"),
)
_LANGUAGE = (
    ("object understood", What.OBJECT.value, ""),
    ("relation understood", What.RELATION.value, ""),
    ("both understood", What.BOTH.value, "parser_accuracy"),
    ("success, noun and relation supplied", What.SUPPLIED.value, "success_supplied"),
    ("success, relation inferred", What.RELATION_INFERRED.value, "success_inferred"),
    ("success, noun and relation inferred", What.INFERRED.value, ""),
)
USED = frozenset(
    {f"{line.row}.{column}" for lines in LINES.values() for line in lines if not line.optional for column in line.columns}
    | {key for *_, key in _INTERVALS}
    | {f"{what}_with_{key}" for *_, key in _NUMBERS_OF_INSTANCES for what in ("success", "episodes")}
)
"""Keys of the paper's figures that the tables show."""


def beside_paper(lines: Sequence[Line], what: str, metrics: Metrics, paper: Paper) -> str:
    """A Markdown table with two rows a line: ours, then the paper's if it has one. what: head of the first column."""
    columns = lines[0].columns
    heads = [*_HEADS, *(column.upper() for column in columns[len(_HEADS) :])]
    body = []
    for line in lines:
        if line.optional and all(found(line.read(column), metrics) is None for column in columns):
            continue
        body.append([line.title, HERE, *(_cell(line.read(column), metrics, line.form) for column in columns)])
        if any(f"{line.row}.{column}" in paper for column in columns):
            body.append(["", PAPER, *(_papers(paper, f"{line.row}.{column}", line.form) for column in columns)])
    return pipe_table([what, "", *heads], body, [False, False, *[True] * len(columns)])


def intervals(metrics: Metrics, paper: Paper) -> str:
    """Embodied success with its interval."""
    body = [
        [
            title,
            _cell(sources.embodied(arm), metrics, Form.RATE),
            _interval(arm, metrics),
            _papers(paper, key, Form.RATE),
        ]
        for title, arm, key in _INTERVALS
    ]
    return pipe_table(["agent", "here", "interval, here", "interval, paper"], body, [False, True, True, True])


def difficulty(metrics: Metrics, paper: Paper) -> str:
    """Static success of the two-visit agent by the number of instances of the category."""
    body = []
    for title, group, key in _NUMBERS_OF_INSTANCES:
        body.append(
            [
                title,
                _cell(sources.with_instances(TWO, group, "n"), metrics, Form.COUNT),
                _cell(sources.with_instances(TWO, group), metrics, Form.RATE),
                _papers(paper, f"episodes_with_{key}", Form.COUNT),
                _papers(paper, f"success_with_{key}", Form.RATE),
            ]
        )
    heads = ["instances of the category", "episodes, here", "success, here", "episodes, paper", "success, paper"]
    return pipe_table(heads, body, [False, True, True, True, True])


def language(metrics: Metrics, paper: Paper) -> str:
    """What is understood of held-out sentences, and the success that is left."""
    body = [
        [title, _cell(sources.language(what), metrics, Form.RATE), _papers(paper, key, Form.RATE)]
        for title, what, key in _LANGUAGE
    ]
    return pipe_table(["held-out sentences", "here", "paper"], body, [False, True, True])


def origins(metrics: Metrics) -> tuple[str, ...]:
    """Where the held-out sentences are from, as the metrics say; none where they say nothing."""
    try:
        return tuple(dict.fromkeys(filter(None, metrics.texts("language.csv", "origin"))))
    except Missing:
        return ()


def _interval(arm: str, metrics: Metrics) -> str:
    ends = [_cell(sources.embodied(arm, ALL, bound), metrics, Form.RATE) for bound in ("low", "high")]
    return EMPTY if EMPTY in ends else " – ".join(ends)


def found(read: Read, metrics: Metrics) -> Cell | None:
    """A figure, or None where the metrics do not have it."""
    try:
        return read(metrics)
    except Missing:
        return None


def _cell(read: Read, metrics: Metrics, form: Form) -> str:
    cell = found(read, metrics)
    return EMPTY if cell is None else written(cell.value, form)


def _papers(paper: Paper, key: str, form: Form) -> str:
    return papers(paper[key], form) if key in paper else EMPTY
