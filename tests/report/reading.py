"""Rows as the stages read them, and tables as their readers do."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from types import SimpleNamespace

import pandas as pd

from ovman.analysis import frames
from ovman.report.tables.table import Table, csv_text
from ovman.settings import Arm
from tests.arms import ARMS, CONFIG


def rows(kind: type, made: Iterable[object]) -> pd.DataFrame:
    """Rows written to a file of metrics and read again."""
    text = pd.read_csv(io.StringIO(frames.csv_text(kind, made)), dtype=str, keep_default_na=False)
    return frames.typed(text, kind)


def data(table: Table) -> list[dict[str, str]]:
    """The rows of the csv of a table."""
    return list(csv.DictReader(io.StringIO(csv_text(table))))


def settings(arms: Sequence[Arm] = ARMS) -> SimpleNamespace:
    """The settings of config.yaml with other arms."""
    return SimpleNamespace(
        arms={arm.name: arm for arm in arms},
        comparisons=CONFIG.comparisons,
        evaluation=CONFIG.evaluation,
        perception=CONFIG.perception,
        success=CONFIG.success,
    )
