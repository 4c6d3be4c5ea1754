"""The tables of a split beside the benchmark's own: its success rates and the audit of its candidates."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd

from ovman.models.settings import Settings
from ovman.report.tables.rates import static_table
from ovman.report.tables.rejections import rejections_table
from ovman.report.tables.table import Table


def split_table(split: str, rates: pd.DataFrame, settings: Settings) -> Table:
    """The static gate on a split, one row an arm that has rates. rates: rows of `Rate`; else as `static_table`."""
    return _of(split, static_table(rates, settings), settings)


def split_rejections_table(split: str, counts: pd.DataFrame, settings: Settings) -> Table:
    """The audit of a split's candidates. counts: rows of `RejectionCount`; else as `rejections_table`."""
    return _of(split, rejections_table(counts, settings), settings)


def _of(split: str, table: Table, settings: Settings) -> Table:
    changes = " or ".join(map(str, settings.splits[split].changes))
    says = f"Split {split}: {changes} instances of the queried category change, each under another relation."
    return replace(table, caption=f"{says} {table.caption}")
