"""Explanations written by hand beside verdicts (explanations.yaml), shown only beside the verdict that they belong to."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Annotated

import yaml
from pydantic import BaseModel, ConfigDict, Field, TypeAdapter, ValidationError

from ovman.report.paper_comparison.statement import Judgement, Statement, Verdict

EXPLANATIONS = Path(__file__).with_name("explanations.yaml")


class Explanation(BaseModel):
    """verdict: the one that is explained. text: Markdown of one paragraph. episodes: those of which frames were inspected."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    verdict: Verdict
    text: Annotated[str, Field(min_length=1)]
    episodes: tuple[str, ...] = ()


_FILE = TypeAdapter(dict[str, Explanation])


def read(statements: Iterable[Statement], path: Path = EXPLANATIONS) -> dict[str, Explanation]:
    """By the key of the statement. Raises ValueError in one line for the key of no statement, and for what is no explanation."""
    try:
        explanations = _FILE.validate_python(yaml.safe_load(path.read_text(encoding="utf-8")) or {})
    except yaml.YAMLError as error:
        raise ValueError(f"{path}: {' '.join(str(error).split())}") from None
    except ValidationError as error:
        first = error.errors()[0]
        raise ValueError(f"{path}: {'.'.join(map(str, first['loc']))}: {first['msg']}") from None
    strangers = sorted(explanations.keys() - {statement.key for statement in statements})
    if strangers:
        raise ValueError(f"{path}: {strangers[0]} is the key of no statement; rename or remove it")
    return explanations


def beside(judgement: Judgement, explanations: Mapping[str, Explanation]) -> str | None:
    """What the page says below a verdict, one paragraph of Markdown; None for a verdict that needs no note.

    A verdict other than the explained one is flagged and its text left out: it was written about other results. A statement that
    does not hold and has no explanation is flagged, too.
    """
    explanation = explanations.get(judgement.statement.key)
    if explanation is None:
        if judgement.verdict is Verdict.FAILS:
            return "No explanation yet: the frames have not been inspected."
        return None
    if explanation.verdict is not judgement.verdict:
        return (
            f"⚠ The explanation at hand was written when the verdict was “{explanation.verdict}”. "
            f"Now it is “{judgement.verdict}”, so the explanation is left out until it is reviewed."
        )
    seen = f" (Looked at: {', '.join(f'`{episode}`' for episode in explanation.episodes)}.)" if explanation.episodes else ""
    return f"{' '.join(explanation.text.split())}{seen} *Written by hand.*"
