"""The paper's statements, and our own about controls: one function each."""

from ovman.report.statements import controls, difficulty, failures, memory, paradigms, validity
from ovman.report.statements.statement import Judgement, Statement, Verdict, explain, judge

GROUPS = (memory.GROUP, paradigms.GROUP, difficulty.GROUP, failures.GROUP, validity.GROUP, controls.GROUP, controls.JOINT)
STATEMENTS = tuple(statement for group in GROUPS for statement in group.statements)

__all__ = ["GROUPS", "STATEMENTS", "Judgement", "Statement", "Verdict", "explain", "judge"]
