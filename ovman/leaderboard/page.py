"""The tables of the leaderboard as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

from ovman.entry import tables
from ovman.entry.release import DECIMALS
from ovman.faults import printable
from ovman.leaderboard.entry import Role
from ovman.leaderboard.standing import Refusal, Standing

BLOCKS = {Role.CONTROL: "controls", Role.DIAGNOSTIC: "diagnostics"}
MARK, ALIKE = "‡", "≡"
"""A control reaches the score; the actions are those of others."""
TITLE = "# Leaderboard"
REPLAYED = (
    "Every row was replayed or judged again on the machine that made this page. A replay shows that the recorded actions come to"
    " this score. It does not show that an agent chose them."
)
CACHED = (
    "This page is a draft: runs of a cache were judged again but not replayed, and whoever could write the cache may have made"
    " them up. Make the page without --cache before you publish it."
)


def as_markdown(found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool = False) -> str:
    """Return the leaderboard as Markdown. cached: Whether runs may be those of a cache."""
    return "\n".join(_lines(found, splits, cached)) + "\n"


def _lines(found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool) -> Iterator[str]:
    yield from (TITLE, "", REPLAYED, *[CACHED] * cached)
    yield "[docs/leaderboard.md](../docs/leaderboard.md) says how to enter and what is checked."
    standing = [one for one in found if isinstance(one, Standing)]
    for split in splits:
        for drives, kind in ((True, "driving"), (False, "static gate")):
            if rows := [one for one in standing if one.split == split and one.drives is drives]:
                yield from ("", f"## {split}, {kind}", "", *_table(rows, drives))
    refused = [one for one in found if isinstance(one, Refusal)]
    if refused:
        yield from ("", "## Refused", "")
    for one in refused:
        yield f"- `{printable(one.place).replace('`', chr(39))}`: {_escape(one.summary)}"
    entries = {one.name: one.entry for one in reversed(standing)}
    if entries:
        yield from ("", "## Entries", "")
    for name in dict.fromkeys(one.name for one in standing):
        entry = entries[name]
        code = f" [Code]({entry.code})." if entry.code else ""
        yield f"- **{_escape(entry.system)}** (`{name}`): {_escape(entry.about)}{code}"


def _table(rows: list[Standing], drives: bool) -> Iterator[str]:
    """Yield the table of the submissions on a split, and its notes: systems by success, then controls, then diagnostics."""
    rows = sorted(rows, key=lambda row: (list(Role).index(row.entry.role), -row.rates[-1].rate, row.name))
    relations = [rate.relation for rate in rows[0].rates]
    cells = [["entry", *relations, "95 %", *["SPL"] * drives, "by", "date", "agent ran" if drives else "runs"]]
    alike = {row.name: _alike(row, rows) for row in rows}
    for role in Role:
        of_role = [row for row in rows if row.entry.role is role]
        if of_role and role in BLOCKS:
            cells.append([f"*{BLOCKS[role]}*", *[""] * (len(cells[0]) - 1)])
        rates = [round(row.rates[-1].rate, DECIMALS) for row in of_role]
        for row, own in zip(of_role, rates, strict=True):
            rank = f"{1 + sum(other > own for other in rates)}. " if role is Role.SYSTEM else ""
            cells.append([f"{rank}[{_escape(row.entry.system)}]({row.name})", *map(_escape, _cells(row, bool(alike[row.name])))])
    yield from tables.table(cells, markdown=True)
    for row in rows:
        if row.reached_by and row.entry.role is Role.SYSTEM:
            reached = "; ".join(f"{name} ({tables.share(rate)})" for name, rate in row.reached_by)
            yield from ("", f"{MARK} {_escape(row.entry.system)}: reached by {reached}.")
    for row in rows:
        if alike[row.name]:
            same = f"its actions are those of {', '.join(alike[row.name])} in every run"
            yield from ("", f"{ALIKE} {_escape(row.entry.system)}: {_escape(same)}.")


def _cells(row: Standing, is_alike: bool) -> list[str]:
    """Return the cells of a row after its name."""
    last = row.rates[-1]
    mark = MARK if row.reached_by and row.entry.role is Role.SYSTEM else ""
    mark += ALIKE if is_alike else ""
    shares = [tables.share(rate.rate) for rate in row.rates]
    spl = [] if last.spl is None else [tables.share(last.spl)]
    bounds = f"{tables.share(last.low)} to {tables.share(last.high)}"
    ran = row.where if row.where is not None else str(row.runs)
    return [*shares[:-1], shares[-1] + mark, bounds, *spl, ", ".join(row.entry.authors), row.entry.date, ran]


def _alike(row: Standing, rows: Sequence[Standing]) -> list[str]:
    """Return those whose actions equal the row's in every run: oracles of the release, and other entries.

    Nothing for a diagnostic, which has no rank.
    """
    if row.entry.role is Role.DIAGNOSTIC or row.traces is None:
        return []
    return [*row.oracles, *(one.entry.system for one in rows if one.traces == row.traces and one.name != row.name)]


def _escape(text: str) -> str:
    """Return text of an entry as Markdown that shows it: one line, without tags, links and cells of its own."""
    return re.sub(r"([\\`|<>\[\]])", r"\\\1", printable(text))
