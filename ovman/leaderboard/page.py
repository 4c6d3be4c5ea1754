"""The tables of the leaderboard as Markdown."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from statistics import fmean

from ovman.entry import tables
from ovman.entry.release import DECIMALS
from ovman.faults import printable
from ovman.leaderboard.entry import Role
from ovman.leaderboard.standing import Refusal, Standing
from ovman.records.draw import Draw

BLOCKS = {Role.CONTROL: "controls", Role.DIAGNOSTIC: "diagnostics"}
MARK, ALIKE, LACKING = "‡", "≡", "—"
"""A control reaches the score; the actions are those of others; the value is missing."""
TITLE = "# Leaderboard"
REPLAYED = (
    "Every row was replayed or judged again on the machine that made this page. A replay shows that the recorded actions come to"
    " this score. It does not show that an agent chose them."
)
FRESH = (
    "Navigation in homes and queries that were drawn after the agents were committed. Entries that ran on every draw rank by"
    " their mean success over all relations ([what this proves](../docs/leaderboard.md#what-a-draw-proves))."
)
UNRANKED = "No draw was given, so no entry has a rank ([how to draw](../docs/draws.md))."
PUBLIC = "The answers of these episodes are public. Rows are in the order of their success and have no rank."
CACHED = (
    "This page is a draft: runs of a cache were judged again but not replayed, and whoever could write the cache may have made"
    " them up. Make the page without --cache before you publish it."
)


def as_markdown(
    found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool = False, draws: Sequence[Draw] = ()
) -> str:
    """Return the leaderboard as Markdown. cached: Whether runs may be those of a cache. draws: Those that rank."""
    return "\n".join(_lines(found, splits, cached, draws)) + "\n"


def _lines(found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool, draws: Sequence[Draw]) -> Iterator[str]:
    yield from (TITLE, "", REPLAYED, *[CACHED] * cached)
    yield "[docs/leaderboard.md](../docs/leaderboard.md) says how to enter and what is checked."
    standing = [one for one in found if isinstance(one, Standing)]
    yield from ("", "## Fresh draws", "", *(_fresh(standing, draws) if draws else [UNRANKED]))
    yield from ("", "## Public splits", "", PUBLIC)
    for split in splits:
        for drives, kind in ((True, "driving"), (False, "static gate")):
            if rows := [one for one in standing if one.split == split and one.drives is drives]:
                yield from ("", f"### {split}, {kind}", "", *_table(rows, drives))
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


@dataclass(frozen=True, slots=True)
class _Drawn:
    """The runs of an entry on draws, by the draws' names. mean: of its success on all draws, None if it lacks one."""

    name: str
    first: Standing
    runs: Mapping[str, Standing]
    mean: float | None

    @staticmethod
    def of(name: str, standing: Sequence[Standing], draws: Sequence[str]) -> _Drawn:
        """Return the runs of an entry; it has some."""
        runs = {one.split: one for one in standing if one.name == name and one.split in draws}
        is_whole = len(runs) == len(draws)
        mean = round(fmean(one.rates[-1].rate for one in runs.values()), DECIMALS) if is_whole else None
        return _Drawn(name, next(iter(runs.values())), runs, mean)

    def acts_like(self, other: _Drawn) -> bool:
        """Return whether another entry has the same actions on every draw that this one ran on."""
        return all(draw in other.runs and one.traces == other.runs[draw].traces for draw, one in self.runs.items())


def _fresh(standing: Sequence[Standing], draws: Sequence[Draw]) -> Iterator[str]:
    """Yield the table of runs on draws of one split, and what the draws are: systems by mean success, then the other roles."""
    split, names = draws[0].split, [draw.name for draw in draws]
    rows = [_Drawn.of(name, standing, names) for name in dict.fromkeys(one.name for one in standing if one.split in names)]
    rows.sort(key=lambda row: (row.mean is None, -(row.mean or 0.0), row.name))
    public = {one.name: tables.share(one.rates[-1].rate) for one in standing if one.split == split and one.drives}
    titles = [f"draw {number}" for number in range(1, len(draws) + 1)]
    cells = [["entry", *titles, "mean", "least to greatest", f"public {split}", "by", "committed", "agent ran"]]
    alike = {row.name: [one.name for one in rows if one is not row and row.acts_like(one)] for row in rows}
    for role in Role:
        of_role = [row for row in rows if row.first.entry.role is role]
        if of_role and role in BLOCKS:
            cells.append([f"*{BLOCKS[role]}*", *[""] * (len(cells[0]) - 1)])
        for row in of_role:
            rivals = [one for one in of_role if one.first.track is row.first.track]
            better = sum(one.mean is not None and row.mean is not None and one.mean > row.mean for one in rivals)
            rank = f"{1 + better}. " if role is Role.SYSTEM and row.mean is not None else ""
            shares = {draw: tables.share(one.rates[-1].rate) for draw, one in row.runs.items()}
            spread = [LACKING, LACKING]
            if row.mean is not None:
                mark = ALIKE if alike[row.name] and role is not Role.DIAGNOSTIC else ""
                spread = [tables.share(row.mean) + mark, f"{min(shares.values())} to {max(shares.values())}"]
            who = [", ".join(row.first.entry.authors), row.first.committed or LACKING, row.first.where or LACKING]
            own = [*(shares.get(draw, LACKING) for draw in names), *spread, public.get(row.name, LACKING)]
            cells.append([rank + _link(row.first), *own, *map(_escape, who)])
    yield from (FRESH, "", *tables.table(cells, markdown=True))
    for row in rows:
        if alike[row.name] and row.first.entry.role is not Role.DIAGNOSTIC:
            same = f"its actions are those of {', '.join(alike[row.name])} in every run"
            yield from ("", f"{ALIKE} {_escape(row.first.entry.system)}: {same}.")
    yield ""
    for title, draw in zip(titles, draws, strict=True):
        yield f"- {title}: `{draw.name}`, {draw.n} episodes in {draw.homes} homes; {_describe_seed(draw)}"


def _describe_seed(draw: Draw) -> str:
    if draw.beacon is not None:
        return f"its seed is round {draw.beacon.round} of drand's quicknet, {draw.beacon.time}"
    assert draw.commitment is not None
    return (
        f"its seed was committed {draw.commitment.time} (`{draw.commitment.sha256[:12]}`) and told after {draw.commitment.closes}"
    )


def _link(row: Standing) -> str:
    return f"[{_escape(row.entry.system)}]({row.name})"


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
        for row in of_role:
            cells.append([_link(row), *map(_escape, _cells(row, bool(alike[row.name])))])
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
