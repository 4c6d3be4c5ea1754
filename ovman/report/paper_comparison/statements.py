"""Every statement, in the order of the page."""

from __future__ import annotations

from ovman.report.paper_comparison import baselines, budget, checks, failures, memory
from ovman.report.paper_comparison.statement import Statement

GROUPS: dict[str, tuple[Statement, ...]] = {
    "Two visits against one": memory.STATEMENTS,
    "Do the existing paradigms fail, and why?": baselines.STATEMENTS,
    "Where the difficulty lies": budget.STATEMENTS,
    "How the agent fails": failures.STATEMENTS,
    "Validity checks": checks.STATEMENTS,
}
STATEMENTS: tuple[Statement, ...] = tuple(statement for group in GROUPS.values() for statement in group)
