"""A static score as a readable text and as JSON."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict

from ovman.analysis.rates import ALL, Interval, Rate
from ovman.analysis.significance import Comparison
from ovman.entry.score import StaticScore

SCHEMA = "ovman-static-score/1"


def as_json(score: StaticScore) -> str:
    """The score as one JSON object with a line feed. Keys as in `StaticScore`; `missing` is a list, `whole` says whether it is a
    score."""
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
        "reference": score.reference if score.released else None,
        "released": [asdict(rate) for rate in score.released],
        "chance": score.chance,
        "tests": [asdict(test) for test in score.tests],
        "untested": score.untested,
    }
    return json.dumps(made, indent=1) + "\n"


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
    for arm, rates in _by_arm(score.rates):
        title = f"{arm}: {score.n} episodes" if score.whole else f"{arm}: PARTIAL, {rates[-1].n} of {score.n} episodes, no score"
        yield from ("", title)
        yield from _table([_header(rates), *(_row(rate, score.chance) for rate in rates)])
    if score.released:
        yield from (
            "",
            "beside it: success of the released arms on the same episodes, and p of McNemar's exact test against them",
        )
        yield from _table(_beside(score))
        yield from _said(score)
    elif score.whole:
        yield from ("", "beside it: nothing; the release has no static arms on these episodes")


def _header(rates: Sequence[Rate]) -> list[str]:
    exact = rates[0].interval is Interval.WILSON
    confidence = f"{100 * rates[0].confidence:g} %"
    return ["relation", "n", "success", f"{confidence} ({'Wilson' if exact else 'Poisson-binomial'})", "chance 1/n"]


def _row(rate: Rate, chance: Mapping[str, float]) -> list[str]:
    return [
        rate.relation,
        str(rate.n),
        _share(rate.rate),
        f"{_share(rate.low)} to {_share(rate.high)}",
        _share(chance[rate.relation]),
    ]


def _beside(score: StaticScore) -> list[list[str]]:
    relations = [rate.relation for rate in _by_arm(score.released)[0][1]]
    rows = [["", *relations, "wins", "losses", "p"]]
    runs = sorted({(test.arm, test.seed) for test in score.tests})
    for arm, rates in _by_arm(score.rates):
        rows.append([f"{arm} (this file)", *_shares(rates, relations), "", "", ""])
    for arm, rates in _by_arm(score.released):
        role = "reference" if arm == score.reference else "control"
        found = [test for test in score.tests if test.baseline == arm and test.relation == ALL]
        label = f"{arm} ({role})"
        rows.append([label, *_shares(rates, relations), *(_test(found[0]) if len(runs) == 1 and found else ["", "", ""])])
        if len(runs) > 1:
            rows += [[f"  {test.arm}, seed {test.seed}", *("" for _ in relations), *_test(test)] for test in found]
    rows.append(["chance 1/n", *(_share(score.chance[relation]) for relation in relations), "", "", ""])
    return rows


def _said(score: StaticScore) -> Iterator[str]:
    """Which controls reach an arm of the file, and what is not tested."""
    for arm, rates in _by_arm(score.rates):
        own = rates[-1].rate
        reach = [f"{name} ({_share(of[-1].rate)})" for name, of in _by_arm(score.released) if _reaches(score, name, of, own)]
        if score.chance[ALL] >= own:
            reach.append(f"chance 1/n ({_share(score.chance[ALL])})")
        if reach:
            yield f"controls reach the score of {arm}, {_share(own)}: {', '.join(reach)}"
    if score.untested:
        yield f"without a paired test: {', '.join(score.untested)}"


def _reaches(score: StaticScore, name: str, rates: Sequence[Rate], own: float) -> bool:
    return name != score.reference and rates[-1].rate >= own


def _test(test: Comparison) -> list[str]:
    return [f"{test.wins:g}", f"{test.losses:g}", f"{test.p:.2g}"]


def _shares(rates: Sequence[Rate], relations: Sequence[str]) -> list[str]:
    of = {rate.relation: _share(rate.rate) for rate in rates}
    return [of.get(relation, "") for relation in relations]


def _by_arm(rates: Sequence[Rate]) -> list[tuple[str, list[Rate]]]:
    arms: dict[str, list[Rate]] = {}
    for rate in rates:
        arms.setdefault(rate.arm, []).append(rate)
    return [*arms.items()]


def _share(value: float) -> str:
    return f"{value:.3f}"


def _table(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Rows of cells in columns, the first to the left."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for row in rows:
        first, *others = (
            cell.ljust(width) if at == 0 else cell.rjust(width) for at, (cell, width) in enumerate(zip(row, widths, strict=True))
        )
        yield f"  {'  '.join([first, *others])}".rstrip()
