"""Explanations written by hand beside verdicts (explanations.yaml), shown only beside the verdict that they belong to.

An explanation carries what was measured: its text quotes figures of the metrics by name, so that no number in it goes stale, and
`given` says what must be true of them for the text to be about these results.
"""

from __future__ import annotations

from collections.abc import Container, Iterable, Iterator, Mapping
from pathlib import Path
from string import Formatter
from typing import Annotated

import yaml
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError, model_validator

from ovman.report.paper_comparison.metrics import Cell, Metrics, Missing
from ovman.report.paper_comparison.paper import Paper
from ovman.report.paper_comparison.statement import Form, Judgement, Quantity, Statement, Verdict, expression, figure, names, true
from ovman.report.paper_comparison.writing import papers, written

EXPLANATIONS = Path(__file__).with_name("explanations.yaml")
PAPERS = "paper."
"""Beginning of a name that a text gives to a figure of the paper: {paper.handover_p:p}."""
NUMBERS = "number."
"""Beginning of a name that a text gives to the number of a statement: {number.two_beat_one}."""


class Explanation(BaseModel):
    """verdict: the one that is explained. under: the readings under which the statement holds, where it holds under some only.

    text: Markdown of one paragraph, in which {name} is a figure of `measured` or of the statement, {paper.key} one of the paper,
    each with its form behind a colon if need be, and {number.key} is the number of a statement. given: an expression over those
    figures that must be true for the text to apply. episodes: those of which frames were inspected.
    """

    model_config = ConfigDict(extra="forbid", frozen=True)

    verdict: Verdict
    under: tuple[str, ...] = ()
    text: Annotated[str, Field(min_length=1)]
    measured: Mapping[str, Quantity] = {}
    given: str | None = None
    episodes: tuple[str, ...] = ()

    @model_validator(mode="after")
    def _consistent(self) -> Explanation:
        if (self.verdict is Verdict.SOME) != bool(self.under):
            raise ValueError(f"under names readings where the verdict is {Verdict.SOME!r}, and only there")
        if self.given is not None:
            expression(self.given)
        for _, form in self.quoted():
            if form and form not in set(Form):
                raise ValueError(f"no figure is written as {form}")
        return self

    def quoted(self) -> Iterator[tuple[str, str]]:
        """The names of figures in the text, each with the form behind its colon. Raises ValueError for unbalanced braces."""
        for _, name, form, _ in Formatter().parse(self.text):
            if name is not None:
                yield name, form or ""

    def wrong(self, statement: Statement, paper: Paper, keys: Container[str]) -> str | None:
        """What does not fit the statement that it is about, in words, or None."""
        known = {*statement.figures, *self.measured}
        used = {name for name, _ in self.quoted()}
        named = used | {name for text in self._expressions() for name in names(text)}
        theirs = {name for name in used if name.startswith(PAPERS)}
        others = {name for name in used if name.startswith(NUMBERS)}
        if strangers := sorted(name for name in others if name.removeprefix(NUMBERS) not in keys):
            return f"{strangers[0]} is the number of no statement"
        if strangers := sorted(named - known - theirs - others):
            return f"{strangers[0]} is no figure of the statement and none that is measured"
        if strangers := sorted(name for name in theirs if name.removeprefix(PAPERS) not in paper):
            return f"{strangers[0]} is no figure of the paper"
        if idle := sorted(set(self.measured) - named):
            return f"{idle[0]} is measured and never quoted"
        readings = statement.readings
        if strangers := sorted(set(self.under) - ({readings.own, *readings.others} if readings else set())):
            return f"{strangers[0]} is no reading of the statement"
        return None

    def _expressions(self) -> list[str]:
        return [*filter(None, [self.given, *(quantity.of for quantity in self.measured.values())])]


_FILE = TypeAdapter(dict[str, Explanation])


def read(statements: Iterable[Statement], path: Path = EXPLANATIONS, paper: Paper | None = None) -> dict[str, Explanation]:
    """By the key of the statement. Raises ValueError in one line for the key of no statement, and for what is no explanation."""
    try:
        explanations = _FILE.validate_python(yaml.safe_load(path.read_text(encoding="utf-8")) or {})
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    by_key = {statement.key: statement for statement in statements}
    if strangers := sorted(explanations.keys() - by_key.keys()):
        raise ValueError(f"{path}: {strangers[0]} is the key of no statement; rename or remove it")
    for key, explanation in explanations.items():
        if wrong := explanation.wrong(by_key[key], paper or Paper.read(), by_key):
            raise ValueError(f"{path}: {key}: {wrong}")
    return explanations


def beside(
    judgement: Judgement,
    explanations: Mapping[str, Explanation],
    metrics: Metrics,
    paper: Paper,
    numbers: Mapping[str, int],
) -> str | None:
    """What the page says below a verdict, one paragraph of Markdown; None for a verdict that needs no note.

    numbers: of the statements on the page, by key.

    A verdict other than the explained one is flagged and its text left out: it was written about other results. So is a text
    that quotes a figure which is not among the metrics, and one that supposes what they do not show. A statement that does not
    hold, or not under every reading, and has no explanation is flagged, too.
    """
    explanation = explanations.get(judgement.statement.key)
    if explanation is None:
        if judgement.verdict in (Verdict.FAILS, Verdict.SOME):
            return "No explanation yet: the frames have not been inspected."
        return None
    now = _in_words(judgement.verdict, judgement.under(Verdict.HOLDS))
    if (then := _in_words(explanation.verdict, explanation.under)) != now:
        return (
            f"⚠ The explanation at hand was written when the verdict was “{then}”. "
            f"Now it is “{now}”, so the explanation is left out until it is reviewed."
        )
    cells = dict(judgement.cells)
    try:
        for name, quantity in explanation.measured.items():
            cells[name] = figure(quantity, cells, metrics)
        text = _filled(explanation, judgement.statement, cells, paper, numbers)
        applies = explanation.given is None or true(explanation.given, cells)
    except Missing as missing:
        return f"⚠ The explanation at hand quotes a figure that is not among the metrics ({missing}), so it is left out."
    if not applies:
        return (
            f"⚠ The explanation at hand supposes that `{explanation.given}`, which these metrics do not show, so it is left out."
        )
    seen = f" (Looked at: {', '.join(f'`{episode}`' for episode in explanation.episodes)}.)" if explanation.episodes else ""
    return f"{text}{seen} *Written by hand.*"


def _in_words(verdict: Verdict, under: Iterable[str]) -> str:
    return f"{verdict}: {', '.join(sorted(under))}" if verdict is Verdict.SOME else str(verdict)


def _filled(
    explanation: Explanation, statement: Statement, cells: Mapping[str, Cell], paper: Paper, numbers: Mapping[str, int]
) -> str:
    """The text as one line, its figures filled in. Raises Missing for one that is not known."""
    quantities, parts = {**statement.figures, **explanation.measured}, []
    for before, name, form, _ in Formatter().parse(" ".join(explanation.text.split())):
        parts.append(before)
        if name is not None and name.startswith(PAPERS):
            parts.append(papers(paper[name.removeprefix(PAPERS)], Form(form or Form.RATE)))
        elif name is not None and name.startswith(NUMBERS):
            parts.append(str(numbers[name.removeprefix(NUMBERS)]))
        elif name is not None:
            if name not in cells:
                raise Missing(f"{name} is not known")
            parts.append(written(cells[name].value, Form(form or quantities[name].form)))
    return "".join(parts)
