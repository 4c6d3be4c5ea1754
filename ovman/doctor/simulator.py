"""Stage `simulator`: the Unity build is looked for, and asked for one frame, once and before any scene needs it."""

from __future__ import annotations

from pathlib import Path

from ovman.doctor.checks import UNITY, State, report
from ovman.sim.unity import Missing


def run(output: Path) -> None:
    """Writes what was found to `output`. unity.Missing, whose one line has the remedy, at the first thing that is not well."""
    found = []
    for check in UNITY:
        one = check()
        print(report([one]), flush=True)
        if one.state is State.ILL:
            raise Missing(one.says, one.remedy)
        found.append(one)
    output.write_text(report(found) + "\n")
