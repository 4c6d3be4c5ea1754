"""Rates and baselines as text for a terminal or Markdown, and as JSON values."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict
from typing import Any

from ovman.analysis.comparisons import Comparison
from ovman.analysis.outcomes import ALL, group_by
from ovman.analysis.rates import Interval, Rate
from ovman.entry.release import Baselines

ENTRIES = "Leaderboard: driving success of its entries on the same episodes"
ENTRIES_KEY = "leaderboard"
"""Key of the rates of the leaderboard's entries. Entries are added over time, so this key is never compared."""


def table(rows: Sequence[Sequence[str]], markdown: bool) -> Iterator[str]:
    """Yield rows of cells in columns as lines, the first column to the left and the others to the right."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for number, row in enumerate(rows):
        cells = [cell.rjust(width) if at else cell.ljust(width) for at, (cell, width) in enumerate(zip(row, widths, strict=True))]
        yield f"| {' | '.join(cells)} |" if markdown else f"  {'  '.join(cells)}".rstrip()
        if markdown and number == 0:
            yield f"|{'|'.join('-' * (width + 2 if at == 0 else width + 1) + ':' * (at > 0) for at, width in enumerate(widths))}|"


def rate_rows(rates: Sequence[Rate], chance: Mapping[str, float]) -> list[list[str]]:
    """Return one row per relation of an arm: n, success, its interval, the SPL if it navigates, and the chance of 1/n."""
    is_exact = rates[0].interval is Interval.WILSON
    interval = f"{100 * rates[0].confidence:g} % ({'Wilson' if is_exact else 'Poisson-binomial'})"
    rows = [["relation", "n", "success", interval, *["SPL"] * (rates[0].spl is not None), "chance 1/n"]]
    for rate in rates:
        spl = [] if rate.spl is None else [share(rate.spl)]
        bounds = f"{share(rate.low)} to {share(rate.high)}"
        rows.append([rate.relation, str(rate.n), share(rate.rate), bounds, *spl, share(chance[rate.relation])])
    return rows


def baseline_rows(rates: Sequence[Rate], baselines: Baselines, judged: str) -> list[list[str]]:
    """Return one row per arm: success by relation and over all, and for released arms wins, losses and p over all.

    If several runs are judged, each has a row of its own below the arm that it is tested against. judged: Title of the arms of
    `rates`.
    """
    relations = [rate.relation for rate in rates if rate.arm == rates[0].arm]
    runs = {(test.arm, test.seed) for test in baselines.tests}
    rows = [["", *relations, "wins", "losses", "p"]]
    rows += [[f"{arm} ({judged})", *_shares(of, relations), "", "", ""] for arm, of in group_by(rates, "arm").items()]
    for arm, of in group_by(baselines.released, "arm").items():
        tests = [test for test in baselines.tests if test.baseline == arm and test.relation == ALL]
        role = "" if arm in baselines.references else " (control)"
        over_all = _test_cells(tests[0]) if tests and len(runs) == 1 else ["", "", ""]
        rows.append([f"{baselines.systems[arm]}{role}", *_shares(of, relations), *over_all])
        if len(runs) > 1:
            rows += [[f"  {test.arm}, seed {test.seed}", *("" for _ in relations), *_test_cells(test)] for test in tests]
    return [*rows, ["chance 1/n", *(share(baselines.chance[relation]) for relation in relations), "", "", ""]]


def entry_rows(baselines: Baselines) -> list[list[str]]:
    """Return one row per entry of the leaderboard: success by relation and over all, then chance."""
    relations = [relation for relation in baselines.chance if relation != ALL] + [ALL]
    rows = [["", *relations], *([name, *_shares(of, relations)] for name, of in baselines.entries.items())]
    return [*rows, ["chance 1/n", *(share(baselines.chance[relation]) for relation in relations)]]


def baseline_lines(rates: Sequence[Rate], baselines: Baselines, judged: str, markdown: bool) -> Iterator[str]:
    """Yield the table of the released arms with its remarks, and that of the leaderboard's entries, as far as there are any.

    Remarks name controls that reach an arm that is judged, and arms that are not tested.
    """
    if baselines.released:
        yield from ("", "Beside it: success of the released arms on the same episodes, and p of McNemar's exact test by seed", "")
        yield from table(baseline_rows(rates, baselines, judged), markdown)
        for arm, of in group_by(rates, "arm").items():
            if reaching := baselines.reaching(of[-1].rate):
                names = "; ".join(f"{name} ({share(rate)})" for name, rate in reaching)
                yield from ("", f"controls reach the score of {arm}, {share(of[-1].rate)}: {names}")
        if baselines.untested:
            yield from ("", f"without a paired test: {'; '.join(baselines.untested)}")
    if baselines.entries:
        yield from ("", ENTRIES, "", *table(entry_rows(baselines), markdown))


def baseline_values(baselines: Baselines) -> dict[str, Any]:
    """Return the baselines as JSON values."""
    entries = {arm: [asdict(rate) for rate in of] for arm, of in baselines.entries.items()}
    return {
        "references": sorted(baselines.references),
        "released": [asdict(rate) for rate in baselines.released],
        "chance": baselines.chance,
        "tests": [asdict(test) for test in baselines.tests],
        "untested": baselines.untested,
        **({ENTRIES_KEY: entries} if entries else {}),
    }


def share(value: float) -> str:
    """Return three decimals of a rate."""
    return f"{value:.3f}"


def _test_cells(test: Comparison) -> list[str]:
    return [f"{test.wins:g}", f"{test.losses:g}", f"{test.p:.2g}"]


def _shares(rates: Sequence[Rate], relations: Sequence[str]) -> list[str]:
    of = {rate.relation: share(rate.rate) for rate in rates}
    return [of.get(relation, "") for relation in relations]
