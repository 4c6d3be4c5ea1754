"""The tables of the leaderboard as Markdown and as one HTML file."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from jinja2 import ChoiceLoader, PackageLoader

from ovman.entry import tables
from ovman.entry.release import DECIMALS
from ovman.leaderboard.entry import Role
from ovman.leaderboard.standing import Refusal, Standing
from ovman.records.record import printable
from ovman.report.show.page import environment

TITLES = {True: "driving", False: "static gate"}
BLOCKS = {Role.CONTROL: "controls", Role.DIAGNOSTIC: "diagnostics"}
RAN = {"evaluator": "in the evaluator's process", "process": "in a process of its own", "server": "on a server"}
MARK, ALIKE = "‡", "≡"
TITLE = "# Leaderboard"
REPLAYED = (
    "Every row was replayed or judged again on the machine that made this page. A replay shows that the recorded actions come to"
    " this score. It does not show that an agent chose them."
)
CACHED = (
    "This page is a draft: runs of a cache were judged again but not replayed, and whoever could write the cache may have made"
    " them up. Make the page without --cache before you publish it."
)


@dataclass(frozen=True, slots=True)
class Table:
    """The submissions on a split that drive, or those that do not. rows: systems by success, then controls, then diagnostics."""

    split: str
    drives: bool
    rows: Sequence[Standing]

    @property
    def title(self) -> str:
        """What it is called."""
        return f"{self.split}, {TITLES[self.drives]}"

    @property
    def columns(self) -> list[str]:
        """The heads of its columns."""
        relations = [rate.relation for rate in self.rows[0].rates]
        return ["", "entry", *relations, "95 %", *["SPL"] * self.drives, "by", "date", "agent ran" if self.drives else "runs"]

    def cells(self, row: Standing) -> list[str]:
        """The cells of a row without its rank."""
        last = row.rates[-1]
        mark = MARK if row.reached_by and row.entry.role is Role.SYSTEM else ""
        mark += ALIKE if self.alike(row) else ""
        shares = [tables.share(rate.rate) for rate in row.rates]
        spl = [] if last.spl is None else [tables.share(last.spl)]
        ran = row.where if row.where is not None else str(row.runs)
        bounds = f"{tables.share(last.low)} to {tables.share(last.high)}"
        return [*shares[:-1], shares[-1] + mark, bounds, *spl, ", ".join(row.entry.authors), row.entry.date, ran]

    def alike(self, row: Standing) -> list[str]:
        """Return the names of those whose actions equal the row's in every run: oracles of the release, and other entries.

        Nothing for a diagnostic, which has no rank.
        """
        if row.entry.role is Role.DIAGNOSTIC or row.traces is None:
            return []
        return [*row.oracles, *(one.entry.system for one in self.rows if one.traces == row.traces and one.name != row.name)]

    def blocks(self) -> Iterator[tuple[str | None, list[tuple[str, Standing]]]]:
        """Blocks with their titles (None for systems), and in each its rows with their ranks ("" where they have none)."""
        for role in Role:
            of = [row for row in self.rows if row.entry.role is role]
            if of:
                ranks = _ranks(of) if role is Role.SYSTEM else [""] * len(of)
                yield BLOCKS.get(role), [*zip(ranks, of, strict=True)]

    @property
    def reached(self) -> list[Standing]:
        """Systems whose score a control reaches."""
        return [row for row in self.rows if row.reached_by and row.entry.role is Role.SYSTEM]


def board(found: Sequence[Standing | Refusal], splits: Sequence[str]) -> list[Table]:
    """The tables, in the order of `splits`, driving before static."""
    standing = [one for one in found if isinstance(one, Standing)]
    made = []
    for split in splits:
        for drives in (True, False):
            rows = [one for one in standing if one.split == split and one.drives is drives]
            if rows:
                rows.sort(key=lambda row: (list(Role).index(row.entry.role), -row.rates[-1].rate, row.name))
                made.append(Table(split, drives, rows))
    return made


def refusals(found: Sequence[Standing | Refusal]) -> list[tuple[str, str]]:
    """Return the submissions that do not stand, with one line on why."""
    return [(one.place, one.summary) for one in found if isinstance(one, Refusal)]


def as_markdown(found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool = False) -> str:
    """The leaderboard as Markdown. cached: whether runs may be those of a cache."""
    return "\n".join(_lines(found, splits, cached)) + "\n"


def as_html(found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool = False) -> str:
    """The leaderboard as one HTML file without script. cached: as for `as_markdown`."""
    styled = environment()
    assert styled.loader is not None, "it has that of its own package"
    made = styled.overlay(loader=ChoiceLoader([PackageLoader("ovman.leaderboard", "templates"), styled.loader]))
    listed = board(found, splits)
    return made.get_template("leaderboard.html").render(
        tables=listed,
        refused=refusals(found),
        mark=MARK,
        share=tables.share,
        ran=RAN,
        entries=_entries(found),
        same=ALIKE,
        said=[REPLAYED, *[CACHED] * cached],
    )


def _escaped(text: str) -> str:
    """Return text of an entry as Markdown that shows it: one line, without tags, links and cells of its own."""
    return re.sub(r"([\\`|<>\[\]])", r"\\\1", printable(text))


def _code(text: str) -> str:
    return f"`{printable(text).replace('`', chr(39))}`"


def _lines(found: Sequence[Standing | Refusal], splits: Sequence[str], cached: bool) -> Iterator[str]:
    yield TITLE
    yield ""
    yield from [REPLAYED, *[CACHED] * cached]
    yield "[docs/leaderboard.md](../docs/leaderboard.md) says how to enter and what is checked."
    for table in board(found, splits):
        yield from ("", f"## {table.title}", "")
        rows = [table.columns[1:]]
        for title, of in table.blocks():
            if title is not None:
                rows.append([f"*{title}*", *[""] * (len(table.columns) - 2)])
            rows += [
                [f"{rank and f'{rank}. '}[{_escaped(row.entry.system)}]({row.name})", *map(_escaped, table.cells(row))]
                for rank, row in of
            ]
        yield from tables.table(rows, markdown=True)
        for row in table.reached:
            yield from ("", f"{MARK} {_escaped(row.entry.system)}: {_reached(row)}.")
        for row in table.rows:
            if others := table.alike(row):
                yield from ("", f"{ALIKE} {_escaped(row.entry.system)}: {_escaped(_same(others))}.")
    if missing := refusals(found):
        yield from ("", "## Refused", "")
        yield from (f"- {_code(place)}: {_escaped(why)}" for place, why in missing)
    if entries := _entries(found):
        yield from ("", "## Entries", "")
    for name, one in entries.items():
        code = f" [Code]({one.entry.code})." if one.entry.code else ""
        yield f"- **{_escaped(one.entry.system)}** (`{name}`): {_escaped(one.entry.about)}{code}"


def _entries(found: Sequence[Standing | Refusal]) -> dict[str, Standing]:
    entries: dict[str, Standing] = {}
    for one in found:
        if isinstance(one, Standing):
            entries.setdefault(one.name, one)
    return entries


def _reached(row: Standing) -> str:
    return "reached by " + "; ".join(f"{name} ({tables.share(rate)})" for name, rate in row.reached_by)


def _same(others: Sequence[str]) -> str:
    return f"its actions are those of {', '.join(others)} in every run"


def _ranks(rows: Sequence[Standing]) -> list[str]:
    """Ranks from 1 by success over all; equal successes have equal ranks."""
    rates = [round(row.rates[-1].rate, DECIMALS) for row in rows]
    return [str(1 + sum(other > own for other in rates)) for own in rates]
