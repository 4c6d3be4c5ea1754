"""Tables as Parquet files: the same rows are the same bytes under one version of pyarrow."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pyarrow
from pyarrow import parquet

from ovman.atomic import clear_partials, replacing
from ovman.dataset.columns import Column, Kind, Table

IMAGE = pyarrow.struct([("bytes", pyarrow.binary()), ("path", pyarrow.string())])
"""As `datasets.Image` stores one."""


def schema(table: Table) -> pyarrow.Schema:
    """The table's columns as Arrow has them, with their Hugging Face features."""
    features = json.dumps({"info": {"features": table.features}}, separators=(",", ":"))
    return pyarrow.schema([(column.name, _type(column)) for column in table.columns], metadata={"huggingface": features})


def write(table: Table, groups: Iterable[Iterable[dict[str, Any]]], file: Path) -> int:
    """Write rows, a row group each of `groups`, of which one is held at a time; returns how many rows there are.

    The file is whole or not there.
    """
    form, number = schema(table), 0
    flat = [column.name for column in table.columns if column.kind is not Kind.IMAGE]
    clear_partials(file)
    with replacing(file) as partial:
        # A PNG is compressed already, and no minimum of pictures is of use.
        writer = parquet.ParquetWriter(
            partial, form, compression="none" if table.pictured else "zstd", use_dictionary=flat, write_statistics=flat
        )
        with writer:
            for rows in groups:
                made = pyarrow.Table.from_pylist([*rows], schema=form)
                writer.write_table(made, row_group_size=max(1, len(made)))
                number += len(made)
    return number


def _type(column: Column) -> pyarrow.DataType:
    return IMAGE if column.kind is Kind.IMAGE else pyarrow.type_for_alias(column.kind.value.arrow)
