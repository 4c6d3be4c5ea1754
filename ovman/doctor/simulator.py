"""Stage `simulator`: checks the Unity build with one frame, once and before any scene needs it."""

from __future__ import annotations

from pathlib import Path

from ovman.doctor.checks import UNITY, State, report
from ovman.sim.unity import Missing


def run(output: Path) -> None:
    """Write the results of the checks to `output`. Raises unity.Missing, one line with the remedy, for the first problem."""
    found = []
    for check in UNITY:
        one = check()
        print(report([one]), flush=True)
        if one.state is State.ILL:
            raise Missing(one.says, one.remedy)
        found.append(one)
    output.write_text(report(found) + "\n")
