"""A static score as a readable text and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

from ovman.entry import tables
from ovman.entry.beside import Beside
from ovman.entry.score import StaticScore

SCHEMA = "ovman-static-score/1"
LEADERBOARD = "leaderboard"
"""Key of the rates of the leaderboard's entries. Entries are added over time, so this key is never compared."""


def as_json(score: StaticScore) -> str:
    """The score as one JSON object with a line feed: keys as in `StaticScore` and `Beside`, and whether it is `whole`."""
    made = {
        "schema": SCHEMA,
        "file": str(score.file),
        "split": score.split,
        "episodes": score.of,
        "n": score.n,
        "radius_m": score.radius_m,
        "whole": score.whole,
        "missing": [{"arm": arm, "seed": seed, "episodes": n} for (arm, seed), n in score.missing.items()],
        "rates": [asdict(rate) for rate in score.rates],
        **as_values(score.beside),
    }
    return json.dumps(made, indent=1) + "\n"


def as_values(beside: Beside) -> dict[str, Any]:
    """What stands beside a score as JSON values."""
    return {
        "references": sorted(beside.references),
        "released": [asdict(rate) for rate in beside.released],
        "chance": beside.chance,
        "tests": [asdict(test) for test in beside.tests],
        "untested": beside.untested,
        **({LEADERBOARD: {arm: [asdict(rate) for rate in of] for arm, of in beside.entries.items()}} if beside.entries else {}),
    }


def as_text(score: StaticScore) -> str:
    """The score as lines of text, each table below what it shows."""
    return "\n".join(_lines(score)) + "\n"


def complaint(score: StaticScore) -> str:
    """What keeps a partial set from being a score, in one line."""
    runs = [f"{arm}, seed {seed}: {n} of {score.n} episodes are missing" for (arm, seed), n in score.missing.items()]
    return f"{score.file}: {'; '.join(runs)}; a part of {score.of} is no score: answer them all, with an abstention where need be"


def _lines(score: StaticScore) -> Iterator[str]:
    radius = " or ".join(f"{radius:g}" for radius in score.radius_m)
    yield f"{score.file}: static gate, a point within {radius} m of the answer, on {score.of}"
    for arm, rates in tables.by_arm(score.rates):
        title = f"{arm}: {score.n} episodes" if score.whole else f"{arm}: PARTIAL, {rates[-1].n} of {score.n} episodes, no score"
        yield from ("", title, *tables.table(tables.of_arm(rates, score.beside.chance), markdown=False))
    if score.beside.released:
        yield from (
            "",
            "beside it: success of the released arms on the same episodes, and p of McNemar's exact test against them",
        )
        yield from tables.table(tables.beside(score.rates, score.beside, "this file"), markdown=False)
        yield from tables.said(score.rates, score.beside)
    elif score.beside.entries:
        yield from ("", tables.ENTRIES, *tables.table(tables.entries(score.beside), markdown=False))
    elif score.whole:
        yield from ("", "beside it: nothing; the release has no static arms on these episodes")
