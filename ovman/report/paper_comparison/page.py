"""The stage "paper_comparison": the page that sets our results beside the paper's (docs/results.md)."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, StrictUndefined

from ovman.analysis.frames import rows_of, typed
from ovman.analysis.scores import Score
from ovman.report.paper_comparison import comparison
from ovman.report.paper_comparison import statement as statements
from ovman.report.paper_comparison.comparison import beside_paper, embodied, static
from ovman.report.paper_comparison.controls import controls_of, meanings
from ovman.report.paper_comparison.explanations import EXPLANATIONS, Explanation, beside
from ovman.report.paper_comparison.explanations import read as read_explanations
from ovman.report.paper_comparison.metrics import ALL, Metrics, Missing, Reading, arms_by_row
from ovman.report.paper_comparison.paper import PAPER, Paper
from ovman.report.paper_comparison.statement import Form, Judgement, Quantity, Verdict, every, judged
from ovman.report.paper_comparison.writing import EMPTY, papers, written
from ovman.report.tables.perception import bars
from ovman.report.tables.position import POSITION, position_table
from ovman.report.tables.table import markdown_body, pipe_table
from ovman.settings import Settings

TEMPLATE = Path(__file__).with_name("page.md.j2")
OWN = Path(__file__).with_name("controls.yaml")
"""Statements of our own."""
FIGURES = "figures"
"""Directory of the figures beside the page, under results/ and under docs/ alike."""
OWN_WEIGHTS = "models/"


@dataclass(frozen=True, slots=True)
class Sources:
    """The files that the page is made from beside the metrics."""

    paper: Path = PAPER
    statements: Path = statements.STATEMENTS
    own: Path = OWN
    explanations: Path = EXPLANATIONS
    template: Path = TEMPLATE
    position: Path = POSITION


_SUMMARY: tuple[tuple[str, str, Reading], ...] = (
    ("reference agent, two visits, static", "static.two", static("static.two")),
    ("reference agent, single visit, static", "static.one", static("static.one")),
    ("reference agent, two visits, navigating", "embodied.two", embodied("embodied.two")),
    ("reference agent, oracle grounding, static", "static.grounding_two", static("static.grounding_two")),
    ("reference agent, oracle positions, static", "static.positions_two", static("static.positions_two")),
    ("DualMap, maintained map, static", "static.dualmap_one", static("static.dualmap_one")),
    ("DualMap, two visits, static", "static.dualmap_two", static("static.dualmap_two")),
    ("CoW, navigating", "embodied.cow", embodied("embodied.cow")),
    ("oracle check, navigating", "embodied.oracle", embodied("embodied.oracle")),
)
_COSTS = {
    "mapping_s": "mapping_s_an_episode",
    "gate_s": "static_gate_s",
    "pass_min": "embodied_pass_min",
    "cow_min": "cow_pass_min",
}
USED = frozenset({"taxonomy.episodes.all", *_COSTS.values(), *(f"{row}.all" for _, row, _ in _SUMMARY)})
"""Keys of the paper's figures that the page shows outside of its tables and statements."""
_MARK = {Verdict.HOLDS: "✓", Verdict.FAILS: "✗", Verdict.SOME: "◐", Verdict.UNKNOWN: "?"}
_BREAK = "<br>"
_RATES = {
    "recall": "recall of true masks",
    "precision": "precision of detected masks",
    "precision_once": "the same, doubled masks wrong",
    "top1": "right category first",
    "top5": "right category among five",
    "synonym_top1": "first, by synonyms",
    "synonym_top5": "among five, by synonyms",
}


def run(metrics_files: Sequence[Path], sources: Sources, constants: Settings, *, page: Path) -> None:
    """Write the page (Markdown), which links to the figures beside it. Byte-stable.

    metrics_files: csv files of results/metrics by their names; a figure that is in none of them makes its verdicts "cannot be
    told" and its cells empty. constants: what the stage owns. Raises ValueError in one line for files that contradict themselves.
    """
    metrics = Metrics.load(metrics_files, arms_by_row(constants.comparisons, constants.paper))
    page.write_text(rendered(metrics, sources, constants), encoding="utf-8", newline="\n")
    groups = (*statements.read(sources.statements), *statements.read(sources.own))
    for judgement in (judged(statement, metrics) for statement in every(groups)):
        print(
            f"{judgement.statement.key}: {mark(judgement)}" + (f" ({judgement.missing})" if judgement.missing else ""),
            flush=True,
        )


def rendered(
    metrics: Metrics, sources: Sources, constants: Settings, explanations: Mapping[str, Explanation] | None = None
) -> str:
    """The page, Markdown. explanations: those of the sources if not given."""
    paper, groups, own = Paper.read(sources.paper), statements.read(sources.statements), statements.read(sources.own)
    if explanations is None:
        explanations = read_explanations(every((*groups, *own)), sources.explanations, paper)
    judgements, ours = (
        {group.title: [judged(statement, metrics) for statement in group.statements] for group in some} for some in (groups, own)
    )
    verdicts = Counter({verdict.value: 0 for verdict in Verdict})
    verdicts.update(judgement.verdict.value for group in judgements.values() for judgement in group)
    numbers = {statement.key: number for number, statement in enumerate(every((*groups, *own)), 1)}

    def shown(title: str, group: Sequence[Judgement], papers_own: bool) -> dict[str, Any]:
        notes = {
            numbers[judgement.statement.key]: "\n\n".join(
                filter(None, (readings_of(judgement), beside(judgement, explanations, metrics, paper, numbers)))
            )
            for judgement in group
        }
        return {
            "title": title,
            "table": _table(group, numbers, paper, "the paper says" if papers_own else "we say"),
            "notes": [{"number": number, "text": text} for number, text in notes.items() if text],
            "decided": [_decided(judgement, numbers, paper, papers_own) for judgement in group],
        }

    episodes = metrics.find(static("static.positions_two", ALL, "n")) or metrics.find(comparison.outcomes(comparison.EPISODES))
    perception = constants.perception
    template = sources.template.read_text(encoding="utf-8")
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    text = environment.from_string(template).render(
        summary=_summary(metrics, paper),
        verdicts=verdicts,
        statements=len(every(groups)),
        episodes=EMPTY if episodes is None else written(episodes.value, Form.COUNT),
        paper_episodes=papers(paper["taxonomy.episodes.all"], Form.COUNT),
        embedded=constants.benchmark.backend == "embedded",
        detector=perception.detector,
        encoder=perception.encoder,
        trained_here=all(name.weights.startswith(OWN_WEIGHTS) for name in (perception.detector, perception.encoder)),
        confidence=f"{100 * constants.evaluation.confidence:.6g} %",
        failing=_all_named(Verdict.FAILS, judgements, numbers),
        hanging=_all_named(Verdict.SOME, judgements, numbers),
        untold=_all_named(Verdict.UNKNOWN, judgements, numbers),
        groups=[shown(title, group, True) for title, group in judgements.items()],
        own=[shown(title, group, False) for title, group in ours.items()],
        controls=controls_of(metrics, constants),
        meanings=meanings(constants),
        static=beside_paper(comparison.static_lines(constants, paper), "arm", metrics, paper),
        embodied=beside_paper(comparison.embodied_lines(constants, paper), "agent", metrics, paper),
        intervals=comparison.intervals(metrics, paper),
        taxonomy=beside_paper(comparison.taxonomy_lines(paper), "outcome", metrics, paper),
        difficulty=comparison.difficulty(metrics, paper),
        language=comparison.language(metrics, paper),
        origins="; ".join(comparison.origins(metrics)),
        perception=_perception(metrics),
        position=markdown_body(position_table(sources.position)),
        figures=FIGURES,
        **{
            name: papers(paper[key], Form.COUNT if key != "mapping_s_an_episode" else Form.EXPECTED)
            for name, key in _COSTS.items()
        },
    )
    return text.rstrip("\n") + "\n"


def _all_named(verdict: Verdict, judgements: Mapping[str, Sequence[Judgement]], numbers: Mapping[str, int]) -> list[str]:
    """The statements with a verdict."""
    return [_named(judgement, numbers) for group in judgements.values() for judgement in group if judgement.verdict is verdict]


def _named(judgement: Judgement, numbers: Mapping[str, int]) -> str:
    return f"({numbers[judgement.statement.key]}) {judgement.statement.claim}"


def _summary(metrics: Metrics, paper: Paper) -> str:
    rows = []
    for words, row, reading in _SUMMARY:
        cell = metrics.find(reading)
        rows.append([words, f"**{written(cell.value, Form.RATE)}**" if cell else EMPTY, papers(paper[f"{row}.all"], Form.RATE)])
    return pipe_table(["success over all episodes", "here", "paper"], rows, [False, True, True])


def _table(group: Sequence[Judgement], numbers: Mapping[str, int], paper: Paper, says: str) -> str:
    rows = [
        [
            str(numbers[judgement.statement.key]),
            judgement.statement.claim,
            _BREAK.join(quantity.label for quantity in judgement.statement.figures.values()),
            _BREAK.join(_here(judgement, name) for name in judgement.statement.figures),
            _BREAK.join(_papers(quantity, paper) for quantity in judgement.statement.figures.values()),
            mark(judgement),
        ]
        for judgement in group
    ]
    heads = ["#", says, "figure", "here", "paper", "verdict"]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (heads, ["-:", "-", "-", "-:", "-:", "-"], *rows))


def mark(judgement: Judgement) -> str:
    """A verdict with its sign; where it depends on the reading, with those under which the claim holds."""
    words = str(judgement.verdict)
    if judgement.verdict is Verdict.SOME:
        under = judgement.under(Verdict.HOLDS)
        words = f"holds under {_some(len(under), len(judgement.readings))} only: {', '.join(under)}"
    return f"{_MARK[judgement.verdict]} {words}".replace(" ", "\u00a0" if judgement.verdict is not Verdict.SOME else " ")


def _some(under: int, of: int) -> str:
    return "one reading" if under == 1 else f"{under} of {of} readings"


def readings_of(judgement: Judgement) -> str | None:
    """What a claim comes to under every reading of the definition that it depends on, a list; None for one reading."""
    if judgement.statement.readings is None:
        return None
    lines = []
    for name, reading in judgement.readings.items():
        quantities = reading.statement.figures.items()
        figures = "; ".join(f"{quantity.label} {_here(reading, key)}" for key, quantity in quantities if quantity.decides)
        lines.append(f"- {_MARK[reading.verdict]} *{name}* – {reading.verdict}: {reading.missing or figures}")
    return "\n".join([f"It depends on a definition: {judgement.statement.readings.definition}.", "", *lines])


def _here(judgement: Judgement, name: str) -> str:
    if name not in judgement.cells:
        return EMPTY
    return written(judgement.cells[name].value, judgement.statement.figures[name].form).replace(" ", "\u00a0")


def _papers(quantity: Quantity, paper: Paper) -> str:
    return EMPTY if quantity.paper is None else papers(paper[quantity.paper], quantity.form).replace(" ", "\u00a0")


def _decided(judgement: Judgement, numbers: Mapping[str, int], paper: Paper, papers_own: bool) -> str:
    """One item of a list: key, test, and where each figure of ours and of the paper's is."""
    statement = judgement.statement
    places = list(dict.fromkeys(paper[quantity.paper].place for quantity in statement.figures.values() if quantity.paper))
    found_at = [f"  - {statement.figures[name].label}: {cell.source}" for name, cell in judgement.cells.items()]
    number, at = numbers[statement.key], f" Paper: {'; '.join(places) or 'in words only'}." if papers_own else ""
    lines = [f"- **{number}** `{statement.key}` holds if {statement.rule}.{at}"]
    if judgement.missing:
        lines.append(f"  - cannot be told: {judgement.missing}")
    for name, reading in list(judgement.readings.items())[1:]:
        another = "" if reading.statement.rule == statement.rule else f"holds if {reading.statement.rule}; "
        sources = "; ".join(cell.source for cell in reading.cells.values())
        found_at.append(f"  - read as *{name}*: {another}{sources or reading.missing}")
    return "\n".join(lines + found_at)


def _perception(metrics: Metrics) -> str:
    try:
        scores = rows_of(Score, typed(metrics.frame("perception"), Score))
    except Missing as error:
        return f"Nothing can be told: {error}.\n"
    body = [
        [_RATES.get(bar.rate, bar.rate), written(bar.reached, Form.RATE), f"≥ {written(bar.least, Form.RATE)}", bar.verdict]
        for bar in bars(scores).values()
    ]
    return pipe_table(["rate", "here", "bar", ""], body, [False, True, True, False])
