"""The stage "findings": the page that sets our results beside the paper's (docs/results.md), and its charts."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from ovman.models.settings import Settings
from ovman.report.markdown import pipe_table
from ovman.report.paper_comparison import charts, comparison, sources
from ovman.report.paper_comparison.baselines import COW, MAINTAINED, TWICE
from ovman.report.paper_comparison.budget import GROUNDING, ORACLE, POSITIONS
from ovman.report.paper_comparison.comparison import EMBODIED, STATIC, TAXONOMY, beside_paper, found
from ovman.report.paper_comparison.explanations import Explanation, beside
from ovman.report.paper_comparison.explanations import read as read_explanations
from ovman.report.paper_comparison.memory import ONE, TWO, TWO_EMBODIED
from ovman.report.paper_comparison.metrics import Metrics, Missing
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.sources import ALL, EPISODES, Read
from ovman.report.paper_comparison.statement import Form, Judgement, Quantity, Verdict, judged
from ovman.report.paper_comparison.statements import GROUPS, STATEMENTS
from ovman.report.paper_comparison.writing import EMPTY, papers, written
from ovman.report.perception import bars

TEMPLATE = Path(__file__).with_name("page.md.j2")
FIGURES = "figures"
"""Directory of the charts beside the page, under results/ and under docs/ alike."""
OWN_WEIGHTS = "models/"

_SUMMARY: tuple[tuple[str, Read, str], ...] = (
    ("two visits, own perception, static", sources.static(TWO), f"static.{TWO}.all"),
    ("one visit, own perception, static", sources.static(ONE), f"static.{ONE}.all"),
    ("two visits, own perception, navigating", sources.embodied(TWO_EMBODIED), f"embodied.{TWO_EMBODIED}.all"),
    ("two visits, grounding handed over, static", sources.static(GROUNDING), f"static.{GROUNDING}.all"),
    ("two visits, positions handed over, static", sources.static(POSITIONS), f"static.{POSITIONS}.all"),
    ("dualmap (reimplemented), maintained map, static", sources.static(MAINTAINED), f"static.{MAINTAINED}.all"),
    ("dualmap (reimplemented), two visits, static", sources.static(TWICE), f"static.{TWICE}.all"),
    ("cow (reimplemented), navigating", sources.embodied(COW), f"embodied.{COW}.all"),
    ("oracle, navigating", sources.embodied(ORACLE), f"embodied.{ORACLE}.all"),
)
_COSTS = {
    "mapping_s": "mapping_s_an_episode",
    "gate_s": "static_gate_s",
    "pass_min": "embodied_pass_min",
    "cow_min": "cow_pass_min",
}
USED = frozenset({"taxonomy.episodes.all", *_COSTS.values(), *(key for *_, key in _SUMMARY)})
"""Keys of the paper's figures that the page shows outside of its tables and statements."""
_MARK = {Verdict.HOLDS: "✓ holds", Verdict.FAILS: "✗ does not hold", Verdict.UNKNOWN: "? cannot be told"}
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


def run(
    metrics_files: Sequence[Path],
    paper_file: Path,
    explanations_file: Path,
    template_file: Path,
    constants: Settings,
    page: Path,
    budget_chart: Path,
    memory_chart: Path,
) -> None:
    """Writes the page (Markdown) and its two charts (PNG). Byte-stable.

    metrics_files: csv files of results/metrics by their names; a figure that none of them has makes its verdicts "cannot be told"
    and its cells empty. constants: what the stage owns. Raises ValueError in one line for files that contradict themselves.
    """
    metrics, paper = Metrics.read(metrics_files), Paper.read(paper_file)
    explanations = read_explanations(explanations_file)
    text = rendered(metrics, paper, explanations, template_file.read_text(encoding="utf-8"), constants)
    page.write_text(text, encoding="utf-8", newline="\n")
    charts.budget(metrics, paper, budget_chart)
    charts.memory(metrics, paper, memory_chart)
    for judgement in (judged(statement, metrics) for statement in STATEMENTS):
        print(
            f"{judgement.statement.key}: {judgement.verdict}" + (f" ({judgement.missing})" if judgement.missing else ""),
            flush=True,
        )


def rendered(metrics: Metrics, paper: Paper, explanations: Mapping[str, Explanation], template: str, constants: Settings) -> str:
    """The page, Markdown."""
    judgements = {title: [judged(statement, metrics) for statement in group] for title, group in GROUPS.items()}
    verdicts = Counter({verdict.value: 0 for verdict in Verdict})
    verdicts.update(judgement.verdict.value for group in judgements.values() for judgement in group)
    numbers = {statement.key: number for number, statement in enumerate(STATEMENTS, 1)}
    episodes = found(sources.static(POSITIONS, ALL, "n"), metrics) or found(sources.outcomes(EPISODES), metrics)
    perception = constants.perception
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    text = environment.from_string(template).render(
        summary=_summary(metrics, paper),
        verdicts=verdicts,
        statements=len(STATEMENTS),
        episodes=EMPTY if episodes is None else written(episodes.value, Form.COUNT),
        paper_episodes=papers(paper["taxonomy.episodes.all"], Form.COUNT),
        embedded=constants.benchmark.backend == "embedded",
        detector=perception.detector,
        encoder=perception.encoder,
        trained_here=all(name.weights.startswith(OWN_WEIGHTS) for name in (perception.detector, perception.encoder)),
        confidence=f"{100 * constants.evaluation.confidence:.6g} %",
        failing=[
            _named(judgement, numbers)
            for group in judgements.values()
            for judgement in group
            if judgement.verdict is Verdict.FAILS
        ],
        untold=[
            _named(judgement, numbers)
            for group in judgements.values()
            for judgement in group
            if judgement.verdict is Verdict.UNKNOWN
        ],
        groups=[
            {
                "title": title,
                "table": _table(group, numbers, paper),
                "notes": [
                    {"number": numbers[judgement.statement.key], "text": note}
                    for judgement in group
                    if (note := beside(judgement, explanations)) is not None
                ],
                "decided": [_decided(judgement, numbers, paper) for judgement in group],
            }
            for title, group in judgements.items()
        ],
        static=beside_paper(STATIC, "arm", metrics, paper),
        embodied=beside_paper(EMBODIED, "agent", metrics, paper),
        intervals=comparison.intervals(metrics, paper),
        taxonomy=beside_paper(TAXONOMY, "outcome", metrics, paper),
        difficulty=comparison.difficulty(metrics, paper),
        language=comparison.language(metrics, paper),
        origins="; ".join(comparison.origins(metrics)),
        perception=_perception(metrics),
        figures=FIGURES,
        **{
            name: papers(paper[key], Form.COUNT if key != "mapping_s_an_episode" else Form.EXPECTED)
            for name, key in _COSTS.items()
        },
    )
    return text.rstrip("\n") + "\n"


def _named(judgement: Judgement, numbers: Mapping[str, int]) -> str:
    return f"({numbers[judgement.statement.key]}) {judgement.statement.claim}"


def _summary(metrics: Metrics, paper: Paper) -> str:
    rows = []
    for words, read, key in _SUMMARY:
        cell = found(read, metrics)
        rows.append([words, f"**{written(cell.value, Form.RATE)}**" if cell else EMPTY, papers(paper[key], Form.RATE)])
    return pipe_table(["success over all episodes", "here", "paper"], rows, [False, True, True])


def _table(group: Sequence[Judgement], numbers: Mapping[str, int], paper: Paper) -> str:
    rows = [
        [
            str(numbers[judgement.statement.key]),
            judgement.statement.claim,
            _BREAK.join(quantity.label for quantity in judgement.statement.quantities),
            _BREAK.join(_here(judgement, quantity) for quantity in judgement.statement.quantities),
            _BREAK.join(_papers(quantity, paper) for quantity in judgement.statement.quantities),
            _MARK[judgement.verdict].replace(" ", "\u00a0"),
        ]
        for judgement in group
    ]
    heads = ["#", "the paper says", "figure", "here", "paper", "verdict"]
    return "".join(f"| {' | '.join(cells)} |\n" for cells in (heads, ["-:", "-", "-", "-:", "-:", "-"], *rows))


def _here(judgement: Judgement, quantity: Quantity) -> str:
    cell = judgement.cells.get(quantity.name)
    return EMPTY if cell is None else written(cell.value, quantity.form).replace(" ", "\u00a0")


def _papers(quantity: Quantity, paper: Paper) -> str:
    return EMPTY if quantity.paper is None else papers(paper[quantity.paper], quantity.form).replace(" ", "\u00a0")


def _decided(judgement: Judgement, numbers: Mapping[str, int], paper: Paper) -> str:
    """One item of a list: key, test, and where each figure of ours and of the paper's is."""
    statement = judgement.statement
    places = list(dict.fromkeys(paper[q.paper].place for q in statement.quantities if q.paper))
    found_at = [f"  - {q.label}: {judgement.cells[q.name].source}" for q in statement.quantities if q.name in judgement.cells]
    number, at = numbers[statement.key], "; ".join(places) or "in words only"
    lines = [f"- **{number}** `{statement.key}` holds if {statement.rule}. Paper: {at}."]
    if judgement.missing:
        lines.append(f"  - cannot be told: {judgement.missing}")
    return "\n".join(lines + found_at)


def _perception(metrics: Metrics) -> str:
    try:
        rows = metrics.rows("perception.csv")
    except Missing as error:
        return f"Nothing can be told: {error}.\n"
    body = [
        [_RATES.get(bar.rate, bar.rate), written(bar.reached, Form.RATE), f"≥ {written(bar.least, Form.RATE)}", bar.verdict]
        for bar in bars(rows).values()
    ]
    return pipe_table(["rate", "here", "bar", ""], body, [False, True, True, False])
