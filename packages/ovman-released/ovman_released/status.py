"""Whether a released system was run, as a record: tables say why a row is not there.

Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

import json
import os
from dataclasses import asdict, dataclass
from pathlib import Path

SCHEMA = "ovman-released/1"


@dataclass(frozen=True)
class Status:
    """system: its title in the tables; says: in one line what is missing and how to get it, empty where it was run."""

    system: str
    says: str = ""

    @property
    def run(self) -> bool:
        return not self.says

    def write(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"schema": SCHEMA, "run": self.run, **asdict(self)}) + "\n", encoding="utf-8")


def read(path: Path) -> Status:
    """Raises ValueError for a file that is no such record."""
    record = json.loads(path.read_text(encoding="utf-8"))
    if not isinstance(record, dict) or record.get("schema") != SCHEMA:
        raise ValueError(f"{path}: is no record {SCHEMA!r}; remove it, and it is made again")
    return Status(record["system"], record["says"])


def note(path: Path) -> str | None:
    """A sentence about a system that was not run, None for one that was. What is missing there is its user's affair."""
    status = read(path)
    return None if status.run else f"{status.system} was not run: results/released/{path.name} says what is missing."


def forget_failures(directory: Path) -> None:
    """Age the records of systems that were not run, so that what was missing is looked for again.

    Snakemake makes again what is older than the script that made it, but not a file that is gone while what follows is there.
    """
    for path in sorted(directory.glob("*.json")):
        if not read(path).run:
            os.utime(path, (1, 1))
