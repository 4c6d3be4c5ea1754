"""From words to a query: an agent of this package reads the relation from the sentence and keeps the noun phrase."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TypeVar

from ovman.agents.interface import NOTHING_NAMED, Abstention, AbstentionReason, Instruction, PredictionContext, Query, Relation
from ovman.language.parser import ParseFailure, read_relation

Outcome = TypeVar("Outcome")
Proof = TypeVar("Proof")


def understand(asked: Instruction) -> Query | Abstention:
    """Return a query as it is, an instruction as a query without a category. Abstains with NOT_PARSED without a relation."""
    if isinstance(asked, Query):
        return asked
    relation = read_relation(asked.sentence, asked.phrase or NOTHING_NAMED)
    if isinstance(relation, ParseFailure):
        return Abstention(AbstentionReason.NOT_PARSED)
    return Query("", Relation(relation), sentence=asked.sentence, phrase=asked.phrase)


def understands(
    predict: Callable[[Query, PredictionContext], tuple[Outcome, Proof]],
) -> Callable[[Instruction, PredictionContext], tuple[Outcome | Abstention, Proof | None]]:
    """Let a static arm, which answers queries, answer instructions, too."""

    @wraps(predict)
    def answer(asked: Instruction, context: PredictionContext) -> tuple[Outcome | Abstention, Proof | None]:
        query = understand(asked)
        return (query, None) if isinstance(query, Abstention) else predict(query, context)

    return answer
