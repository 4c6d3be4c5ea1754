"""What Snakemake recorded of an output when its job was done, read and written.

From these records Snakemake knows under which parameter and from which inputs an output was made. An output without one is taken
for done whatever the constants are, so results that are put in place need theirs.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

RECORDS = Path(".snakemake")
"""In the working directory."""


@dataclass(frozen=True)
class Done:
    """A job that is done, as one of its outputs knows it.

    parameter: the canonical text of its constants and its code. inputs: names as the rule gives them, sorted. log: its log, which
    no other job has; "" for a rule without one.
    """

    rule: str
    parameter: str
    inputs: tuple[str, ...]
    log: str


class Records:
    """The records of a working directory."""

    def __init__(self, directory: Path) -> None:
        from snakemake.persistence.file import FilePersistence  # half a second of imports

        self._records: Any = FilePersistence(nolock=True, path=directory / RECORDS)

    def read(self, output: str) -> Done | None:
        """What is recorded of an output; None where nothing is. ValueError for a record with anything but one parameter."""
        found = self._records._read_record(output)
        if found is None:
            return None
        try:
            (parameter,) = (ast.literal_eval(text) for text in found.params)
        except (ValueError, SyntaxError, TypeError):
            raise ValueError(f"{output}: Snakemake's record of it has no one parameter; make it again") from None
        return Done(found.rule, parameter, tuple(found.input), " ".join(found.log or ()))

    def write(self, output: str, done: Done, made: float, digests: Mapping[str, str]) -> None:
        """Record that a job made an output. made: seconds since the epoch; digests: SHA-256 of inputs that are files."""
        from snakemake.persistence import RECORD_FORMAT_VERSION, MetadataRecord

        record = MetadataRecord(
            rule=done.rule,
            input=sorted(done.inputs),
            log=done.log.split(),
            params=[repr(done.parameter)],
            record_format_version=RECORD_FORMAT_VERSION,
            starttime=made,
            endtime=made,
            incomplete=False,
            input_checksums={name: f"sha256:{digest}" for name, digest in digests.items()},
        )
        self._records._write_record(output, record)
