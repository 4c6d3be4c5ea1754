"""Write the pages that set our results next to the paper's: docs/results.md, docs/verdicts.md and docs/beyond.md.

The first has the paper's tables and the main claims, the second every statement (ovman/report/statements), the third what goes
beyond the paper. A number that the metrics lack leaves its cell empty and its verdict open.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from functools import reduce
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from jinja2 import Environment, FileSystemLoader, StrictUndefined

from ovman.analysis.statistics import RESAMPLES
from ovman.report.metrics import Metrics, Missing, name_arms
from ovman.report.paper import COUNT, DIFFERENCE, EMPTY, PAPER, RATE, TITLES, Form, P, write
from ovman.report.statements import GROUPS, STATEMENTS, Judgement, Verdict, explain, judge
from ovman.report.statements.statement import SURE, Figure
from ovman.report.tables.columns import RELATIONS
from ovman.report.tables.perception import bars, perception_scores
from ovman.report.tables.success import TABLES
from ovman.report.tables.table import ALL, make_table, markdown_body, percent, pipe_table
from ovman.settings import Arm, Kind, Settings, Source
from ovman.settings.arms import Reading

HERE = Path(__file__).parent
PAGES = ("results", "verdicts", "beyond")
OWN_WEIGHTS = "models/"
COLUMNS = (*RELATIONS, ALL)
OUTCOMES = ("success", "abstain", "elsewhere", "near_miss", "wrong_instance", "lost_in_navigation")
"""Rows of Table "taxonomy"."""
SENTENCES = {
    "object": ("object understood", ""),
    "relation": ("relation understood", ""),
    "both": ("both understood", "parser_accuracy"),
    "supplied": ("success, noun and relation supplied", ""),
    "relation_inferred": ("success, relation inferred", ""),
    "noun_inferred": ("success, noun inferred", "success_supplied"),
    "inferred": ("success, noun and relation inferred", "success_inferred"),
}
"""Title and key of the paper's figure by the rows of language.csv."""
PERCEPTION = {
    "recall": "recall of true masks",
    "precision": "precision of detected masks",
    "precision_once": "the same, doubled masks wrong",
    "top1": "right category first",
    "top5": "right category among five",
    "synonym_top1": "first, by synonyms",
    "synonym_top5": "among five, by synonyms",
}
MARKS = {Verdict.HOLDS: "✓", Verdict.FAILS: "✗", Verdict.UNDECIDED: "~", Verdict.SOME: "◐", Verdict.UNKNOWN: "?"}


def write_pages(metric_files: Sequence[Path], settings: Settings, directory: Path) -> None:
    """Write the pages, Markdown, and print a line per verdict. metric_files: of all splits.

    Settings: all that the choices name, arms, splits, comparisons, paper, benchmark.backend, names and weights of the networks
    (perception), evaluation.confidence, success.radius_m.
    """
    metrics = Metrics.load(metric_files, name_arms(settings.comparisons, settings.paper))
    judgements = judge_all(metrics)
    for name, text in render(metrics, judgements, settings).items():
        (directory / f"{name}.md").write_text(text, encoding="utf-8", newline="\n")
    for key, judgement in judgements.items():
        print(f"{key}: {mark(judgement)}" + (f" ({judgement.missing})" if judgement.missing else ""), flush=True)


def judge_all(metrics: Metrics) -> dict[str, Judgement]:
    """Return the judgement of every statement, by key."""
    return {statement.key: judge(statement, metrics) for statement in STATEMENTS}


def render(metrics: Metrics, judgements: dict[str, Judgement], settings: Settings) -> dict[str, str]:
    """Return the pages as Markdown, by name. Equal files give equal text."""
    of_paper = [judgement for judgement in judgements.values() if judgement.statement.about_paper]
    counts = Counter(judgement.verdict.value for judgement in of_paper)
    networks = (settings.perception.detector, settings.perception.encoder)
    episodes = metrics.write("static_rates", "n", arm="static.positions_two")
    if episodes == EMPTY:
        episodes = metrics.write("taxonomy", "n", arm="agent", verdict="success")
    loader = FileSystemLoader(HERE)
    environment = Environment(  # noqa: S701 (Markdown)
        loader=loader, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True
    )
    environment.filters |= {"here": _write_cell, "printed": _write_printed}
    contents = {
        "verdicts": {verdict.value: counts[verdict.value] for verdict in Verdict},
        "statements": len(of_paper),
        "episodes": episodes,
        "paper": _write_paper,
        "embedded": settings.benchmark.backend == "embedded",
        "detector": networks[0],
        "encoder": networks[1],
        "trained_here": all(network.weights.startswith(OWN_WEIGHTS) for network in networks),
        "confidence": percent(settings.evaluation.confidence),
        "sure": percent(SURE),
        "unsure": percent(1.0 - SURE),
        "resamples": RESAMPLES,
        "groups": GROUPS,
        "listed": [judgement for judgement in of_paper if judgement.statement.is_listed],
        "open": (Verdict.FAILS, Verdict.SOME),
        "judged": lambda group: [judgements[statement.key] for statement in group.statements],
        "lead": lambda judgement: _write_lead(judgement, settings.evaluation.confidence),
        "share": lambda judgement: EMPTY if judgement.share is None else f"{100 * judgement.share:.0f}\u00a0%",
        "mark": mark,
        "note": lambda judgement: explain(judgement) or "",
        "reason": _shorten_reason,
        "readings": _list_readings,
        "sources": _list_sources,
        "choices": tabulate_choices(settings),
        "times": yaml.safe_load((HERE / "times.yaml").read_text(encoding="utf-8")),
        "overview": _show_table(metrics, settings, "overview"),
        "ranks": _show_table(metrics, settings, "ranks"),
        "meanings": _describe_controls(metrics, settings),
        "static": _tabulate_arms(metrics, settings, Kind.STATIC),
        "embodied": _tabulate_arms(metrics, settings, Kind.EMBODIED),
        "taxonomy": _tabulate_taxonomy(metrics),
        "language": _tabulate_language(metrics),
        "origins": _name_origins(metrics),
        "perception": _unless_missing(lambda: _tabulate_perception(metrics)),
    }
    pages = {name: environment.get_template(f"{name}_page.md.j2").render(contents) for name in PAGES}
    return {name: text.strip("\n") + "\n" for name, text in pages.items()}


def read_choices() -> list[dict[str, Any]]:
    """Return the choices where the paper is silent or where we deviate: choice, paper, ours, effect, names of constants."""
    entries: list[dict[str, Any]] = yaml.safe_load((HERE / "choices.yaml").read_text(encoding="utf-8"))
    return entries


def tabulate_choices(settings: Settings) -> str:
    """Return the table of choices as Markdown, with the values of the constants in force."""
    rows = []
    for entry in read_choices():
        values = [f"`{name}: {reduce(getattr, name.split('.'), settings)}`" for name in entry.get("settings", ())]
        rows.append([entry["choice"], entry["paper"], "; ".join([entry["ours"], *values]), entry["effect"]])
    return pipe_table(["choice", "the paper", "here", "effect"], rows, [False] * 4)


def _unless_missing(tabulate: Callable[[], str]) -> str:
    try:
        return tabulate()
    except Missing as missing:
        return f"Nothing can be told: {missing}.\n"


def _show_table(metrics: Metrics, settings: Settings, name: str) -> str:
    """Return a table of results/all with its caption."""

    def tabulate() -> str:
        table = make_table(TABLES[name], metrics.frame(name), settings)
        return f"{table.caption}\n\n{markdown_body(table)}"

    return _unless_missing(tabulate)


# Statements


def mark(judgement: Judgement) -> str:
    """Return a verdict with its sign, and the readings under which the claim holds if it depends on the reading."""
    text = f"{MARKS[judgement.verdict]} {judgement.verdict}".replace(" ", "\u00a0")
    return f"{text}: holds by {', '.join(judgement.under(Verdict.HOLDS))}" if judgement.verdict is Verdict.SOME else text


def _write_lead(judgement: Judgement, confidence: float) -> str:
    """Write the narrowest margin of a claim, or its p, with the interval over resamples."""
    margin = judgement.narrowest
    if margin is None:
        return EMPTY
    cell = margin.by if margin.shown is None else margin.shown
    form = DIFFERENCE if margin.shown is None else P
    if abs(margin.by) >= 1.0 and form is DIFFERENCE:
        return f"{float(margin.by):+.0f}".replace("-", "−")
    texts = [write(float(cell), form)]
    if cell.draws is not None and form is not P:
        outside = (1.0 - confidence) / 2.0
        ends = np.nanquantile(cell.draws, [outside, 1.0 - outside])
        texts.append(f"({' to '.join(write(end, form) for end in ends)})")
    return ("p = " if form is P else "") + " ".join(texts).replace(" ", "\u00a0")


def _write_cell(figure: Figure) -> str:
    return f"{figure.cell}".replace(" ", "\u00a0")


def _write_printed(figure: Figure) -> str:
    return _write_paper(figure.paper, figure.cell.form).replace(" ", "\u00a0")


def _shorten_reason(judgement: Judgement) -> str:
    """Return the first sentence of a reason and what it rests on."""
    reason, explanation = explain(judgement) or "", judgement.evidence.explanation
    if explanation is None or not reason.endswith(".)*"):
        return reason
    first = " ".join(explanation.text.split()).partition(". ")[0].rstrip(".")
    return f"{first}. *({explanation.label.capitalize()}.)*"


def _list_readings(judgement: Judgement) -> str:
    """Return what a claim comes to under every reading of its definition, a list; nothing for one reading."""
    if judgement.statement.readings is None:
        return ""
    lines = []
    for name, reading in judgement.readings.items():
        figures = "; ".join(f"{figure.label} {_write_cell(figure)}" for figure in reading.evidence.figures if figure.decides)
        said = "— (not evaluated)" if reading.missing else f"{reading.verdict}: {figures}"
        lines.append(f"- {MARKS[reading.verdict]} *{name}*: {said}")
    return "\n".join([f"It depends on a definition: {judgement.statement.readings.definition}.", "", *lines, "", ""])


def _list_sources(judgement: Judgement) -> str:
    """Return an item of a list: the key, the test, and where each figure of ours and of the paper's is from."""
    statement, figures = judgement.statement, judgement.evidence.figures
    places = "; ".join(dict.fromkeys(PAPER[figure.paper].place for figure in figures if figure.paper in PAPER))
    of_paper = f" Paper: {places or 'in words only'}." if statement.about_paper else ""
    lines = [f"- `{statement.key}` holds if {statement.holds_if}.{of_paper}"]
    if judgement.missing:
        lines.append(f"  - cannot be told: {judgement.missing}")
    lines += [f"  - {figure.label}: {figure.cell.source}" for figure in figures]
    for name, other in statement.readings.others.items() if statement.readings else ():
        reading = judgement.readings[name]
        test = f"holds if {other.holds_if}; " if other.holds_if else ""
        sources = "; ".join(figure.cell.source for figure in reading.evidence.figures)
        lines.append(f"  - read as *{name}*: {test}{sources or reading.missing}")
    return "\n".join(lines)


# Tables


def _write_paper(key: str, form: Form = RATE) -> str:
    return PAPER[key].write(form) if key in PAPER else EMPTY


def _tabulate_rows(head: str, rows: Sequence[tuple[str, str, Sequence[str]]], columns: Sequence[str], form: Form = RATE) -> str:
    """Return a table with two rows per row: ours, then the paper's if it has one.

    rows: title, row of the paper ("static.two"), and our cells. columns: relations, or "spl". form: of the paper's cells.
    """
    body = []
    for title, row, cells in rows:
        body.append([title, "here", *cells])
        if any(f"{row}.{column}" in PAPER for column in columns):
            body.append(["", "paper", *(_write_paper(f"{row}.{column}", form) for column in columns)])
    return pipe_table([head, "", *(column.upper() for column in columns)], body, [False, False, *[True] * len(columns)])


def _tabulate_arms(metrics: Metrics, settings: Settings, kind: Kind) -> str:
    rows: list[tuple[str, str, list[str]]] = []
    for title, arm, row in list_arms(settings, kind):
        if f"{row}.all" not in PAPER or row in {of for _, of, _ in rows}:
            continue  # the tables have every arm
        cells = [metrics.write(f"{kind}_rates", arm=arm, relation=relation) for relation in COLUMNS]
        if kind is Kind.EMBODIED:
            cells.append(metrics.write("embodied_rates", "spl", arm=arm))
        rows.append((title, row, cells))
    return _tabulate_rows("arm", rows, COLUMNS) if kind is Kind.STATIC else _tabulate_rows("agent", rows, (*COLUMNS, "spl"))


def list_arms(settings: Settings, kind: Kind) -> list[tuple[str, str, str]]:
    """Return title, arm and row of the paper of the arms of section `paper`.

    The first arm of a row has the paper's title if there is one, others have their own.
    """
    rows = settings.paper.static if kind is Kind.STATIC else settings.paper.embodied
    listed: list[tuple[str, str, str]] = []
    for name, row in rows.items():
        if name in settings.arms:
            key, title = f"{kind}.{row}", _title(settings.arms[name])
            is_first = key not in {of for _, _, of in listed}
            listed.append((TITLES.get(key, title) if is_first else title, name, key))
    return listed


def _title(arm: Arm) -> str:
    if arm.kind is Kind.EMBODIED:
        return arm.system
    title = f"{arm.system}, {arm.memory}"
    if arm.positions is Source.HANDED:
        return f"{title}, oracle positions"
    if arm.grounding is Source.HANDED:
        return f"{title}, oracle grounding" + (f" ({arm.reading})" if arm.reading is not Reading.MAJORITY else "")
    return title


def _tabulate_taxonomy(metrics: Metrics) -> str:
    def count(outcome: str, relation: str) -> str:
        verdict, column = ("success", "n") if outcome == "episodes" else (outcome, "episodes")
        try:
            rows = metrics.rows("taxonomy", arm="agent", verdict=verdict, relation=relation)
            return f"{(rows.of_seed(0) if outcome == 'lost_in_navigation' else rows).one(column)}"
        except Missing:
            return EMPTY

    keys = {outcome: f"taxonomy.{outcome}" for outcome in OUTCOMES}
    rows = [(TITLES[key], key, [count(outcome, relation) for relation in COLUMNS]) for outcome, key in keys.items()]
    return _tabulate_rows("outcome", rows, COLUMNS, COUNT)


def _tabulate_language(metrics: Metrics) -> str:
    body = [[title, metrics.write("language", what=what), _write_paper(key)] for what, (title, key) in SENTENCES.items()]
    return pipe_table(["held-out sentences", "here", "paper"], body, [False, True, True])


def _name_origins(metrics: Metrics) -> str:
    """Say where the held-out sentences are from."""
    try:
        return "; ".join(dict.fromkeys(filter(None, metrics.frame("language")["origin"])))
    except Missing:
        return ""


def _tabulate_perception(metrics: Metrics) -> str:
    body = [
        [PERCEPTION[bar.rate], write(bar.reached), f"≥ {write(bar.least)}", bar.verdict]
        for bar in bars(perception_scores(metrics.frame("perception"))).values()
    ]
    return pipe_table(["rate", "here", "bar", ""], body, [False, True, True, False])


def _describe_controls(metrics: Metrics, settings: Settings) -> list[str]:
    """Return a line for each control that some split has evaluated: its title, and what its result means."""
    try:
        shown = {*metrics.frame("controls")["arm"]}
    except Missing:
        return []
    controls = [(settings.arms[name], entry.means) for name, entry in settings.comparisons.controls.items() if name in shown]
    return [f"**{arm.system}** ({arm.kind}). {means}" for arm, means in controls if means]
