"""`snakemake --lint`, less what is explained here: python -m ovman.workflow.lint. Exit status 1 where anything else is found."""

from __future__ import annotations

import re
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXPLAINED: Mapping[str, str] = {
    "Specify a conda environment or container for each rule.": (
        "all rules run in the environment that Snakemake runs in, whose exact versions requirements.lock has"
    ),
}
"""Titles of lints that hold here for a reason."""


def findings(text: str) -> list[str]:
    """What Snakemake's linter says, without the explained titles: "item: title", an item and a title a line."""
    found, item = [], ""
    for line in text.splitlines():
        if heading := re.fullmatch(r"Lints for (.*):", line):
            item = heading[1]
        elif (title := re.fullmatch(r"    \* (.*):", line)) and title[1] not in EXPLAINED:
            found.append(f"{item}: {title[1]}")
    return found


def main() -> int:
    """Lint the Snakefile of the repository; the exit status."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", str(ROOT / "Snakefile"), "--lint"]
    said = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    text = said.stdout + said.stderr
    if "Lints for" not in text and said.returncode != 0:
        print(text, file=sys.stderr)
        return 1
    found = findings(text)
    print("\n".join(found), end="\n" if found else "")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
