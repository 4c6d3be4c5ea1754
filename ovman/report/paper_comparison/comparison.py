"""The tables of the page: ours beside the paper's, a row each, and what could not be found left empty."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

from ovman.analysis.difficulty import MANY, By
from ovman.analysis.language import What
from ovman.analysis.taxonomy import LOST, Verdict
from ovman.records.relation import Relation
from ovman.report.paper_comparison.metrics import ALL, Metrics, Missing, Reading
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.statement import Form
from ovman.report.paper_comparison.writing import EMPTY, papers, written
from ovman.report.tables.table import pipe_table
from ovman.settings import Arm, Kind, Settings, Source
from ovman.settings.arms import Reading as Handover

HERE, PAPER = "here", "paper"
RELATIONS = tuple(relation.value for relation in Relation)
EPISODES = "episodes"
"""The row of the taxonomy that counts all episodes."""
_EVERY = (*RELATIONS, ALL)
_INTERVALS = ("one", "two", "positions_two")
_NUMBERS_OF_INSTANCES = (("two", "2", "two"), ("three", "3", "three"), ("four or more", f"{MANY}+", "more"))
_LANGUAGE = (
    ("object understood", What.OBJECT, ""),
    ("relation understood", What.RELATION, ""),
    ("both understood", What.BOTH, "parser_accuracy"),
    ("success, noun and relation supplied", What.SUPPLIED, ""),
    ("success, relation inferred", What.RELATION_INFERRED, ""),
    ("success, noun inferred", What.NOUN_INFERRED, "success_supplied"),
    ("success, noun and relation inferred", What.INFERRED, "success_inferred"),
)


@dataclass(frozen=True, slots=True)
class Line:
    """One row of ours and one of the paper's. title: of both; row: the paper's, "static.two"; columns: their keys.

    reading: where the figure of ours for a column is.
    """

    title: str
    row: str
    columns: tuple[str, ...]
    reading: Callable[[str], Reading]
    form: Form = Form.RATE


def static(arm: str, relation: str = ALL, column: str = "rate") -> Reading:
    """A static arm's success on a relation, or on all episodes. arm: its name, or a row of the paper."""
    return Reading(file="static_rates", where={"arm": arm, "relation": relation}, column=column)


def embodied(arm: str, relation: str = ALL, column: str = "rate") -> Reading:
    """An embodied arm's success, the mean over its seeds. arm: its name, or a row of the paper."""
    return Reading(file="embodied_rates", where={"arm": arm, "relation": relation}, column=column)


def outcomes(verdict: str, relation: str = ALL) -> Reading:
    """How many episodes of the agent have a verdict; EPISODES: how many there are. LOST is counted under the first seed."""
    shown = Verdict.SUCCESS.value if verdict == EPISODES else verdict
    return Reading(
        file="taxonomy",
        where={"arm": "agent", "verdict": shown, "relation": relation},
        column="n" if verdict == EPISODES else "episodes",
        nth_seed=0 if verdict == LOST else None,
    )


def static_lines(settings: Settings, paper: Paper) -> list[Line]:
    """The static arms of section `paper`, each beside its row of the paper."""
    return [Line(title, row, _EVERY, partial(static, arm)) for title, arm, row in _beside(settings, paper, Kind.STATIC)]


def embodied_lines(settings: Settings, paper: Paper) -> list[Line]:
    """The embodied arms of section `paper`, each beside its row of the paper."""
    return [
        Line(title, row, (*_EVERY, "spl"), partial(_embodied_or_spl, arm))
        for title, arm, row in _beside(settings, paper, Kind.EMBODIED)
    ]


def _embodied_or_spl(arm: str, column: str) -> Reading:
    return embodied(arm, ALL, "spl") if column == "spl" else embodied(arm, column)


def taxonomy_lines(paper: Paper) -> list[Line]:
    """The outcomes of the agent, each beside its row of the paper."""
    rows = (*(verdict.value for verdict in Verdict), EPISODES, LOST)
    return [Line(paper.titles[f"taxonomy.{row}"], f"taxonomy.{row}", _EVERY, partial(outcomes, row), Form.COUNT) for row in rows]


def _beside(settings: Settings, paper: Paper, kind: Kind) -> list[tuple[str, str, str]]:
    """Title, arm and row of the paper. The first arm of a row has the paper's title if the row has one, others have their own."""
    rows = settings.paper.static if kind is Kind.STATIC else settings.paper.embodied
    lines, seen = [], set()
    for name, row in rows.items():
        if name in settings.arms:
            key = f"{kind}.{row}"
            own = _title(settings.arms[name])
            lines.append((own if row in seen else paper.titles.get(key, own), name, key))
            seen.add(row)
    return lines


def _title(arm: Arm) -> str:
    if arm.kind is Kind.EMBODIED:
        return arm.system
    title = f"{arm.system}, {arm.memory}"
    if arm.positions is Source.HANDED:
        return f"{title}, oracle positions"
    if arm.grounding is Source.HANDED:
        return f"{title}, oracle grounding" + (f" ({arm.reading})" if arm.reading is not Handover.MAJORITY else "")
    return title


def beside_paper(lines: Sequence[Line], what: str, metrics: Metrics, paper: Paper) -> str:
    """A Markdown table with two rows a line: ours, then the paper's if it has one. what: head of the first column."""
    columns = lines[0].columns if lines else _EVERY
    body = []
    for line in lines:
        body.append([line.title, HERE, *(_cell(line.reading(column), metrics, line.form) for column in columns)])
        if any(f"{line.row}.{column}" in paper for column in columns):
            body.append(["", PAPER, *(_papers(paper, f"{line.row}.{column}", line.form) for column in columns)])
    return pipe_table([what, "", *(column.upper() for column in columns)], body, [False, False, *[True] * len(columns)])


def intervals(metrics: Metrics, paper: Paper) -> str:
    """Embodied success with its interval."""
    body = [
        [
            paper.titles[f"embodied.{row}"],
            _cell(embodied(f"embodied.{row}"), metrics),
            _interval(f"embodied.{row}", metrics),
            _papers(paper, f"embodied_interval_{row}"),
        ]
        for row in _INTERVALS
    ]
    return pipe_table(["agent", "here", "interval, here", "interval, paper"], body, [False, True, True, True])


def difficulty(metrics: Metrics, paper: Paper) -> str:
    """Static success of the two-visit agent by the number of instances of the category."""

    def reading(group: str, column: str) -> Reading:
        return Reading(file="difficulty", where={"by": By.INSTANCES.value, "group": group, "arm": "static.two"}, column=column)

    body = [
        [
            title,
            _cell(reading(group, "n"), metrics, Form.COUNT),
            _cell(reading(group, "rate"), metrics),
            _papers(paper, f"episodes_with_{key}", Form.COUNT),
            _papers(paper, f"success_with_{key}"),
        ]
        for title, group, key in _NUMBERS_OF_INSTANCES
    ]
    heads = ["instances of the category", "episodes, here", "success, here", "episodes, paper", "success, paper"]
    return pipe_table(heads, body, [False, True, True, True, True])


def language(metrics: Metrics, paper: Paper) -> str:
    """What is understood of held-out sentences, and the success that is left."""
    body = [
        [title, _cell(Reading(file="language", where={"what": what.value}), metrics), _papers(paper, key)]
        for title, what, key in _LANGUAGE
    ]
    return pipe_table(["held-out sentences", "here", "paper"], body, [False, True, True])


def origins(metrics: Metrics) -> tuple[str, ...]:
    """Where the held-out sentences are from, as the metrics say; empty where they say nothing."""
    try:
        return tuple(dict.fromkeys(filter(None, metrics.frame("language")["origin"])))
    except Missing:
        return ()


def keys_of(lines: Sequence[Line], paper: Paper) -> set[str]:
    """Keys of the paper's figures that tables of the page show: those of `lines`, of the intervals and of the difficulty."""
    return (
        {key for line in lines for column in line.columns if (key := f"{line.row}.{column}") in paper}
        | {f"embodied_interval_{row}" for row in _INTERVALS}
        | {f"{what}_with_{key}" for *_, key in _NUMBERS_OF_INSTANCES for what in ("success", "episodes")}
    )


def _interval(arm: str, metrics: Metrics) -> str:
    ends = [_cell(embodied(arm, ALL, bound), metrics) for bound in ("low", "high")]
    return EMPTY if EMPTY in ends else " – ".join(ends)


def _cell(reading: Reading, metrics: Metrics, form: Form = Form.RATE) -> str:
    cell = metrics.find(reading)
    return EMPTY if cell is None else written(cell.value, form)


def _papers(paper: Paper, key: str, form: Form = Form.RATE) -> str:
    return papers(paper[key], form) if key in paper else EMPTY
