"""Tables of rates, and of what stands beside them, as text to be read in a terminal or as Markdown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from ovman.analysis.rates import ALL, Interval, Rate
from ovman.analysis.significance import Comparison
from ovman.entry.beside import Beside

ENTRIES = "Leaderboard: driving success of its entries on the same episodes"
DECIMALS = 6
"""Of released rates: a control that ties must not seem to fall short by what the file has rounded away."""


def table(rows: Sequence[Sequence[str]], markdown: bool) -> Iterator[str]:
    """Rows of cells in columns as lines, the first column to the left and the others to the right."""
    widths = [max(len(row[column]) for row in rows) for column in range(len(rows[0]))]
    for number, row in enumerate(rows):
        cells = [cell.rjust(width) if at else cell.ljust(width) for at, (cell, width) in enumerate(zip(row, widths, strict=True))]
        yield f"| {' | '.join(cells)} |" if markdown else f"  {'  '.join(cells)}".rstrip()
        if markdown and number == 0:
            yield f"|{'|'.join('-' * (width + 2 if at == 0 else width + 1) + ':' * (at > 0) for at, width in enumerate(widths))}|"


def of_arm(rates: Sequence[Rate], chance: Mapping[str, float]) -> list[list[str]]:
    """A row a relation of one arm: n, success, its interval, the chance of 1/n, and the SPL of an arm that drives."""
    exact = rates[0].interval is Interval.WILSON
    interval = f"{100 * rates[0].confidence:g} % ({'Wilson' if exact else 'Poisson-binomial'})"
    drives = rates[0].spl is not None
    rows = [["relation", "n", "success", interval, *["SPL"] * drives, "chance 1/n"]]
    for rate in rates:
        spl = [] if rate.spl is None else [share(rate.spl)]
        bounds = f"{share(rate.low)} to {share(rate.high)}"
        rows.append([rate.relation, str(rate.n), share(rate.rate), bounds, *spl, share(chance[rate.relation])])
    return rows


def beside(rates: Sequence[Rate], found: Beside, judged: str) -> list[list[str]]:
    """A row an arm: success by relation and over all, and of released arms wins, losses and p over all.

    Where several runs are judged, each has a row of its own below the arm that it is tested against. judged: what the arms of
    `rates` are called.
    """
    relations = [rate.relation for rate in by_arm(rates)[0][1]]
    runs = {(test.arm, test.seed) for test in found.tests}
    rows = [["", *relations, "wins", "losses", "p"]]
    rows += [[f"{arm} ({judged})", *_shares(of, relations), "", "", ""] for arm, of in by_arm(rates)]
    for arm, of in by_arm(found.released):
        tests = [test for test in found.tests if test.baseline == arm and test.relation == ALL]
        role = "" if arm in found.references else " (control)"
        over_all = _test(tests[0]) if tests and len(runs) == 1 else ["", "", ""]
        rows.append([f"{found.systems[arm]}{role}", *_shares(of, relations), *over_all])
        if len(runs) > 1:
            rows += [[f"  {test.arm}, seed {test.seed}", *("" for _ in relations), *_test(test)] for test in tests]
    return [*rows, ["chance 1/n", *(share(found.chance[relation]) for relation in relations), "", "", ""]]


def entries(found: Beside) -> list[list[str]]:
    """One row per entry of the leaderboard: driving success by relation and over all, then chance."""
    relations = [relation for relation in found.chance if relation != ALL] + [ALL]
    rows = [["", *relations], *([name, *_shares(of, relations)] for name, of in found.entries.items())]
    return [*rows, ["chance 1/n", *(share(found.chance[relation]) for relation in relations)]]


def said(rates: Sequence[Rate], found: Beside) -> Iterator[str]:
    """Lines on which controls reach an arm that is judged, and on what is not tested."""
    for arm, of in by_arm(rates):
        own = of[-1].rate
        if reach := reaching(own, found):
            there = "; ".join(f"{name} ({share(rate)})" for name, rate in reach)
            yield f"controls reach the score of {arm}, {share(own)}: {there}"
    if found.untested:
        yield f"without a paired test: {'; '.join(found.untested)}"


def reaching(own: float, found: Beside) -> list[tuple[str, float]]:
    """The controls, and chance, whose success over all is no lower than `own`, each with it."""
    controls = [(found.systems[name], of[-1].rate) for name, of in by_arm(found.released) if name not in found.references]
    there = [*controls, ("chance 1/n", found.chance[ALL])]
    return [(name, rate) for name, rate in there if round(rate, DECIMALS) >= round(own, DECIMALS)]


def by_arm(rates: Sequence[Rate]) -> list[tuple[str, list[Rate]]]:
    """The rates of each arm, in the order in which they come."""
    arms: dict[str, list[Rate]] = {}
    for rate in rates:
        arms.setdefault(rate.arm, []).append(rate)
    return [*arms.items()]


def share(value: float) -> str:
    """Three decimals."""
    return f"{value:.3f}"


def _test(test: Comparison) -> list[str]:
    return [f"{test.wins:g}", f"{test.losses:g}", f"{test.p:.2g}"]


def _shares(rates: Sequence[Rate], relations: Sequence[str]) -> list[str]:
    of = {rate.relation: share(rate.rate) for rate in rates}
    return [of.get(relation, "") for relation in relations]
