"""Success of agents that are blind to a part of the query, against the chance that a split leaves them."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from statistics import fmean

from ovman.analysis.outcomes import Outcome, count_alike, group_by
from ovman.analysis.rates import rates
from ovman.analysis.rows import Row
from ovman.records.episode import Episode
from ovman.settings import Arm

BOUNDS = "kind arm blind by group n rate low high inverse_n inverse_m inverse_k bound excess within"
INVERSES = ("inverse_n", "inverse_m", "inverse_k")
BOUND_OF = {"noun": "inverse_m", "relation": "inverse_k", "visit": "inverse_n"}
"""The chance of an agent by what it is blind to."""
MARGIN = 0.02
"""By so much a rate may exceed its bound."""


def bounds(outcomes: Sequence[Outcome], episodes: Sequence[Episode], arms: Mapping[str, Arm], confidence: float) -> list[Row]:
    """List the rates of all arms that are blind to something, by relation and by category, with the chances of the same episodes.

    n: instances of the category; m: queries of the same world pair with the same relation; k: those with the same category.
    Episodes without a pair have the changes alike for m and nothing for k. Excess, within: rate - bound, and whether that is at
    most MARGIN; both are None without a bound.
    """
    blind = [outcome for outcome in outcomes if arms[outcome.arm].blind is not None]
    found: list[Row] = []
    for by in ("relation", "category"):
        chances = {group: _chances(of, episodes) for group, of in group_by(episodes, by).items()}
        for row in rates(blind, ("kind", "arm", by), confidence):
            chance, to = chances[row[by]], arms[row["arm"]].blind
            bound = chance[BOUND_OF[str(to)]]
            excess = None if bound is None else row["rate"] - bound
            verdict = {"bound": bound, "excess": excess, "within": None if excess is None else excess <= MARGIN}
            found.append({**row, **chance, **verdict, "blind": to, "by": by, "group": row[by]})
    place = {name: number for number, name in enumerate(arms)}
    return sorted(found, key=lambda row: (row["kind"], place[row["arm"]], row["by"] != "relation"))


def _chances(chosen: Sequence[Episode], episodes: Sequence[Episode]) -> dict[str, float | None]:
    """Return the means of 1/n, 1/m and 1/k over some of the episodes of a split."""
    alike, asked = count_alike(episodes), Counter((one.pair, one.category) for one in episodes)
    paired = all(one.pair is not None for one in chosen)
    return {
        "inverse_n": fmean(1 / one.instances_in_category for one in chosen),
        "inverse_m": fmean(1 / alike[one.id] for one in chosen),
        "inverse_k": fmean(1 / asked[one.pair, one.category] for one in chosen) if paired else None,
    }
