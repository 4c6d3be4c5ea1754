"""The paper's statements, and our own about controls: one function each. The page of results numbers them in this order."""

from ovman.report.statements import controls, difficulty, failures, memory, paradigms, validity
from ovman.report.statements.statement import Judgement, Statement, Verdict, explain, judge

GROUPS = (memory.GROUP, paradigms.GROUP, difficulty.GROUP, failures.GROUP, validity.GROUP, controls.GROUP, controls.JOINT)
STATEMENTS = tuple(statement for group in GROUPS for statement in group.statements)
NUMBERS = {statement.key: number for number, statement in enumerate(STATEMENTS, 1)}

__all__ = ["GROUPS", "NUMBERS", "STATEMENTS", "Judgement", "Statement", "Verdict", "explain", "judge"]
