"""The choices where the paper is silent or where we deviate, one source for every page that shows them (choices.yaml)."""

from __future__ import annotations

from functools import reduce
from pathlib import Path
from typing import Any

import yaml

from ovman.report.tables.table import pipe_table
from ovman.settings import Settings

CHOICES = Path(__file__).with_name("choices.yaml")


def read_choices() -> list[dict[str, Any]]:
    """Return the entries: choice, paper, ours, effect, and names of constants if there are any."""
    entries: list[dict[str, Any]] = yaml.safe_load(CHOICES.read_text(encoding="utf-8"))
    return entries


def tabulate_choices(settings: Settings) -> str:
    """Return the table of choices as Markdown, with the values of the constants in force."""
    rows = []
    for entry in read_choices():
        values = [f"`{name}: {reduce(getattr, name.split('.'), settings)}`" for name in entry.get("settings", ())]
        rows.append([entry["choice"], entry["paper"], "; ".join([entry["ours"], *values]), entry["effect"]])
    return pipe_table(["choice", "the paper", "here", "effect"], rows, [False] * 4)
