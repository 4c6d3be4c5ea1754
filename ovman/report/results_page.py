"""Write the page that sets our results next to the paper's (docs/results.md).

Its parts are the verdicts on statements (ovman/report/statements), and tables in which each row of ours stands above the
paper's. A number that the metrics lack leaves its cell empty and its verdict open.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from jinja2 import Environment, StrictUndefined

from ovman.report.metrics import Metrics, Missing, name_arms
from ovman.report.paper import COUNT, EMPTY, PAPER, RATE, TITLES, Form, write
from ovman.report.statements import GROUPS, NUMBERS, STATEMENTS, Judgement, Verdict, explain, judge
from ovman.report.statements.statement import Figure
from ovman.report.tables.benchmark import position_table
from ovman.report.tables.columns import RELATIONS
from ovman.report.tables.perception import bars, perception_scores
from ovman.report.tables.success import TABLES
from ovman.report.tables.table import ALL, make_table, markdown_body, percent, pipe_table
from ovman.settings import Arm, Kind, Settings, Source
from ovman.settings.arms import Reading

TEMPLATE = Path(__file__).with_name("results_page.md.j2")
OWN_WEIGHTS = "models/"
COLUMNS = (*RELATIONS, ALL)
SUMMARY = {
    "reference agent, two visits, static": "static.two",
    "reference agent, single visit, static": "static.one",
    "reference agent, two visits, navigating": "embodied.two",
    "reference agent, oracle grounding, static": "static.grounding_two",
    "reference agent, oracle positions, static": "static.positions_two",
    "DualMap, maintained map, static": "static.dualmap_one",
    "DualMap, two visits, static": "static.dualmap_two",
    "CoW, navigating": "embodied.cow",
    "oracle check, navigating": "embodied.oracle",
}
OUTCOMES = ("success", "abstain", "elsewhere", "near_miss", "wrong_instance", "episodes", "lost_in_navigation")
"""Rows of Table "taxonomy"."""
INTERVALS = ("one", "two", "positions_two")
INSTANCES = {"2": ("two", "two"), "3": ("three", "three"), "4+": ("four or more", "more")}
"""Title and key of the paper's figures by the number of instances of the category."""
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
MARKS = {Verdict.HOLDS: "✓", Verdict.FAILS: "✗", Verdict.SOME: "◐", Verdict.UNKNOWN: "?"}


def write_page(metric_files: Sequence[Path], settings: Settings, page: Path) -> None:
    """Write the page, Markdown, and print a line per verdict. metric_files: of the split main and of all splits.

    Settings: arms, comparisons.agent, comparisons.controls, paper, benchmark.backend, names and weights of the networks
    (perception), evaluation.confidence.
    """
    metrics = Metrics.load(metric_files, name_arms(settings.comparisons, settings.paper))
    judgements = judge_all(metrics)
    page.write_text(render(metrics, judgements, settings), encoding="utf-8", newline="\n")
    for key, judgement in judgements.items():
        print(f"{key}: {mark(judgement)}" + (f" ({judgement.missing})" if judgement.missing else ""), flush=True)


def judge_all(metrics: Metrics) -> dict[str, Judgement]:
    """Return the judgement of every statement, by key."""
    return {statement.key: judge(statement, metrics, NUMBERS) for statement in STATEMENTS}


def render(metrics: Metrics, judgements: dict[str, Judgement], settings: Settings) -> str:
    """Return the page as Markdown. Equal files give equal text."""
    of_paper = [judgement for judgement in judgements.values() if judgement.statement.about_paper]
    counts = Counter(judgement.verdict.value for judgement in of_paper)
    networks = (settings.perception.detector, settings.perception.encoder)
    episodes = metrics.write("static_rates", "n", arm="static.positions_two")
    if episodes == EMPTY:
        episodes = metrics.write("taxonomy", "n", arm="agent", verdict="success")
    environment = Environment(undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True, keep_trailing_newline=True)
    environment.filters |= {"here": _write_cell, "printed": _write_printed}
    text = environment.from_string(TEMPLATE.read_text(encoding="utf-8")).render(
        summary=_tabulate_summary(metrics),
        verdicts={verdict.value: counts[verdict.value] for verdict in Verdict},
        statements=len(of_paper),
        episodes=episodes,
        paper=_write_paper,
        embedded=settings.benchmark.backend == "embedded",
        detector=networks[0],
        encoder=networks[1],
        trained_here=all(network.weights.startswith(OWN_WEIGHTS) for network in networks),
        confidence=percent(settings.evaluation.confidence),
        failing=_name_those(Verdict.FAILS, of_paper),
        hanging=_name_those(Verdict.SOME, of_paper),
        untold=_name_those(Verdict.UNKNOWN, of_paper),
        groups=GROUPS,
        judged=lambda group: [judgements[statement.key] for statement in group.statements],
        numbers=NUMBERS,
        mark=mark,
        note=_write_note,
        sources=_list_sources,
        controls=_unless_missing(lambda: _tabulate_controls(metrics, settings)),
        meanings=_describe_controls(metrics, settings),
        static=_tabulate_arms(metrics, settings, Kind.STATIC),
        embodied=_tabulate_arms(metrics, settings, Kind.EMBODIED),
        intervals=_tabulate_intervals(metrics),
        taxonomy=_tabulate_taxonomy(metrics),
        difficulty=_tabulate_difficulty(metrics),
        language=_tabulate_language(metrics),
        origins=_name_origins(metrics),
        perception=_unless_missing(lambda: _tabulate_perception(metrics)),
        position=markdown_body(position_table(settings)),
    )
    return text.rstrip("\n") + "\n"


def _unless_missing(tabulate: Callable[[], str]) -> str:
    try:
        return tabulate()
    except Missing as missing:
        return f"Nothing can be told: {missing}.\n"


# Statements


def mark(judgement: Judgement) -> str:
    """Return a verdict with its sign, and the readings under which the claim holds if it depends on the reading."""
    sign = MARKS[judgement.verdict]
    if judgement.verdict is not Verdict.SOME:
        return f"{sign} {judgement.verdict}".replace(" ", "\u00a0")
    under, of = judgement.under(Verdict.HOLDS), len(judgement.readings)
    return f"{sign} holds under {'one reading' if len(under) == 1 else f'{len(under)} of {of} readings'} only: {', '.join(under)}"


def _name_those(verdict: Verdict, judgements: Sequence[Judgement]) -> list[str]:
    statements = [judgement.statement for judgement in judgements if judgement.verdict is verdict]
    return [f"({NUMBERS[statement.key]}) {statement.claim}" for statement in statements]


def _write_note(judgement: Judgement) -> str:
    return "\n\n".join(filter(None, (_list_readings(judgement), explain(judgement))))


def _write_cell(figure: Figure) -> str:
    return f"{figure.cell}".replace(" ", "\u00a0")


def _write_printed(figure: Figure) -> str:
    return _write_paper(figure.paper, figure.cell.form).replace(" ", "\u00a0")


def _list_readings(judgement: Judgement) -> str | None:
    """Return what a claim comes to under every reading of its definition, a list; None for one reading."""
    if judgement.statement.readings is None:
        return None
    lines = []
    for name, reading in judgement.readings.items():
        figures = "; ".join(f"{figure.label} {_write_cell(figure)}" for figure in reading.evidence.figures if figure.decides)
        lines.append(f"- {MARKS[reading.verdict]} *{name}* – {reading.verdict}: {reading.missing or figures}")
    return "\n".join([f"It depends on a definition: {judgement.statement.readings.definition}.", "", *lines])


def _list_sources(judgement: Judgement) -> str:
    """Return an item of a list: the key, the test, and where each figure of ours and of the paper's is from."""
    statement, figures = judgement.statement, judgement.evidence.figures
    places = "; ".join(dict.fromkeys(PAPER[figure.paper].place for figure in figures if figure.paper))
    of_paper = f" Paper: {places or 'in words only'}." if statement.about_paper else ""
    lines = [f"- **{NUMBERS[statement.key]}** `{statement.key}` holds if {statement.holds_if}.{of_paper}"]
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


def _tabulate_summary(metrics: Metrics) -> str:
    rows = []
    for title, row in SUMMARY.items():
        rate = metrics.write(f"{row.split('.')[0]}_rates", arm=row)
        rows.append([title, EMPTY if rate == EMPTY else f"**{rate}**", _write_paper(f"{row}.all")])
    return pipe_table(["success over all episodes", "here", "paper"], rows, [False, True, True])


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
    rows = []
    for title, arm, row in list_arms(settings, kind):
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


def _tabulate_intervals(metrics: Metrics) -> str:
    body = []
    for row in INTERVALS:
        rate, low, high = (metrics.write("embodied_rates", column, arm=f"embodied.{row}") for column in ("rate", "low", "high"))
        interval = EMPTY if EMPTY in (low, high) else f"{low} – {high}"
        body.append([TITLES[f"embodied.{row}"], rate, interval, _write_paper(f"embodied_interval_{row}")])
    return pipe_table(["agent", "here", "interval, here", "interval, paper"], body, [False, True, True, True])


def _tabulate_difficulty(metrics: Metrics) -> str:
    body = []
    for group, (title, key) in INSTANCES.items():
        here = [metrics.write("difficulty", name, by="instances", group=group, arm="static.two") for name in ("n", "rate")]
        body.append([title, *here, _write_paper(f"episodes_with_{key}", COUNT), _write_paper(f"success_with_{key}")])
    heads = ["instances of the category", "episodes, here", "success, here", "episodes, paper", "success, paper"]
    return pipe_table(heads, body, [False, True, True, True, True])


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


def _tabulate_controls(metrics: Metrics, settings: Settings) -> str:
    return markdown_body(make_table(TABLES["controls"], metrics.frame("controls"), settings))


def _describe_controls(metrics: Metrics, settings: Settings) -> list[str]:
    """Return a line for each control that some split has evaluated: its title, and what its result means."""
    try:
        shown = {*metrics.frame("controls")["arm"]}
    except Missing:
        return []
    controls = [(settings.arms[name], entry.means) for name, entry in settings.comparisons.controls.items() if name in shown]
    return [f"**{arm.system}** ({arm.kind}). {means}" for arm, means in controls if means]
