"""The tables of a split beside the benchmark's own: its success rates and the audit of its candidates."""

from __future__ import annotations

from dataclasses import replace

import pandas as pd

from ovman.report.tables.rates import embodied_table, static_table
from ovman.report.tables.rejections import rejections_table
from ovman.report.tables.table import Table
from ovman.settings import Settings, Split


def split_table(split: str, rates: pd.DataFrame, settings: Settings) -> Table:
    """The static gate on a split, one row an arm that has rates. rates: rows of `Rate`; else as `static_table`."""
    return _of(split, static_table(rates, settings), settings)


def split_embodied_table(split: str, rates: pd.DataFrame, settings: Settings) -> Table:
    """The embodied evaluation on a split, one row an arm that has rates. rates: rows of `Rate`; else as `embodied_table`."""
    return _of(split, embodied_table(rates, settings), settings)


def split_rejections_table(split: str, counts: pd.DataFrame, settings: Settings) -> Table:
    """The audit of a split's candidates. counts: rows of `RejectionCount`; else as `rejections_table`."""
    return _of(split, rejections_table(counts, settings), settings)


def _of(split: str, table: Table, settings: Settings) -> Table:
    return replace(table, caption=f"Split {split}: {differs(settings.splits[split])}. {table.caption}")


def differs(split: Split) -> str:
    """In what a split differs from the paper's protocol, in words."""
    says = []
    if not split.single:
        changes = " or ".join(map(str, split.changes))
        says.append(f"{changes} instances of the queried category change, each under another relation")
    if split.others is not None:
        fewest, most = split.others.count
        number = f"{fewest}" if fewest == most else f"{fewest} to {most}"
        says.append(f"{number} instances of other categories change as well")
    own = [what for what, has in (("views", split.second_tour), ("light", split.light)) if has is not None]
    if own:
        says.append(f"the second tour has {' and '.join(own)} of its own")
    if split.sensors is not None:
        says.append(f"depth and poses err (sensors: {split.sensors})")
    return "; ".join(says) or "the paper's protocol"
