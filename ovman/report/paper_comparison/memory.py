"""Statements on two visits against one (Section "Is the task solvable, and does memory matter?")."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ovman.report.paper_comparison.sources import (
    ALL,
    CURRENT,
    PAST,
    RELATIONS,
    compared,
    highest,
    largest_p,
    less,
    lowest,
    mean,
    navigated,
    static,
)
from ovman.report.paper_comparison.statement import Form, Quantity, Statement

ONE, TWO = "single_visit", "two_visits"
ONE_EMBODIED, TWO_EMBODIED = "single_visit_embodied", "two_visits_embodied"
ALPHA = 0.05
"""Level of every test that the paper gives no level for."""
OVERALL = 0.001
MARGINAL = (0.01, 0.1)
NEGLIGIBLE = 0.05
SEEDS = range(3)


def _rates(relation: str) -> tuple[Quantity, ...]:
    return (
        Quantity("two", "two visits", static(TWO, relation), f"static.{TWO}.{relation}"),
        Quantity("one", "one visit", static(ONE, relation), f"static.{ONE}.{relation}"),
    )


def _ahead(relation: str) -> Statement:
    """Two visits beat one on this relation after Holm's correction."""
    return Statement(
        key=f"two_beat_one_{relation}",
        claim=f"On {relation.upper()} two visits beat one, after Holm's correction over the six relations.",
        quantities=(
            *_rates(relation),
            Quantity("p", "corrected p", compared(TWO, ONE, "p_holm", relation), f"static_p_{relation}", Form.P),
        ),
        rule=f"the rate with two visits is higher and the corrected p is below {ALPHA}",
        holds=lambda q: q["two"] > q["one"] and q["p"] < ALPHA,
    )


def ahead_embodied(key: str, claim: str, baseline: str, papers: Sequence[str], shown: Sequence[Quantity] = ()) -> Statement:
    """That the agent with two visits beats another embodied arm.

    papers: keys of the paper's wins, losses and p; shown: figures that stand before these.
    """
    wins, losses, p = papers
    return Statement(
        key=key,
        claim=claim,
        quantities=(
            *shown,
            Quantity("wins", "wins", compared(TWO_EMBODIED, baseline, "wins"), wins, Form.COUNT),
            Quantity("losses", "losses", compared(TWO_EMBODIED, baseline, "losses"), losses, Form.COUNT),
            Quantity("p", "largest p of the seeds", largest_p(TWO_EMBODIED, baseline), p, Form.P),
        ),
        rule=f"more wins than losses (first seed), and an exact p below {OVERALL} under every seed",
        holds=lambda q: q["wins"] > q["losses"] and q["p"] < OVERALL,
    )


def _only_removed_survives(q: Mapping[str, float]) -> bool:
    return q["removed"] < ALPHA and all(q[relation] >= ALPHA for relation in RELATIONS if relation != "removed")


_MARGINS = [less(navigated(TWO_EMBODIED, "sr", seed), navigated(ONE_EMBODIED, "sr", seed)) for seed in SEEDS]

STATEMENTS: tuple[Statement, ...] = (
    Statement(
        key="two_beat_one",
        claim="With its own perception, the agent that keeps two visits beats the one that keeps a single visit.",
        quantities=(
            *_rates(ALL),
            Quantity("p", "exact p", compared(TWO, ONE, "p"), "static_p_all", Form.P),
            Quantity(
                "n_two", "successes, two visits", static(TWO, ALL, "successes"), "two_visits_successes", Form.COUNT, decides=False
            ),
            Quantity(
                "n_one",
                "expected, one visit",
                static(ONE, ALL, "successes"),
                "single_visit_expected_successes",
                Form.EXPECTED,
                decides=False,
            ),
        ),
        rule=f"the rate with two visits is higher and the exact p over all episodes is below {OVERALL}",
        holds=lambda q: q["two"] > q["one"] and q["p"] < OVERALL,
    ),
    *(_ahead(relation) for relation in ("removed", "former", "moved", "moving")),
    Statement(
        key="appeared_is_marginal",
        claim="On APPEARED the margin is marginal.",
        quantities=(
            *_rates("appeared"),
            Quantity("p", "corrected p", compared(TWO, ONE, "p_holm", "appeared"), "static_p_appeared", Form.P),
        ),
        rule=f"the rate with two visits is higher and the corrected p lies between {MARGINAL[0]} and {MARGINAL[1]}",
        holds=lambda q: q["two"] > q["one"] and MARGINAL[0] <= q["p"] <= MARGINAL[1],
    ),
    Statement(
        key="stable_gains_nothing",
        claim="On STABLE, which a single visit can in principle read off, a second visit buys nothing significant.",
        quantities=(
            *_rates("stable"),
            Quantity("p", "corrected p", compared(TWO, ONE, "p_holm", "stable"), "static_p_stable", Form.P),
        ),
        rule=f"the corrected p is at least {ALPHA}",
        holds=lambda q: q["p"] >= ALPHA,
    ),
    Statement(
        key="memory_is_largest_on_the_past",
        claim="Memory is worth most where the answer is a place of the past.",
        quantities=(
            Quantity(
                "past",
                "mean margin, past relations",
                mean([less(static(TWO, r), static(ONE, r)) for r in PAST]),
                None,
                Form.DIFFERENCE,
            ),
            Quantity(
                "current",
                "mean margin, others",
                mean([less(static(TWO, r), static(ONE, r)) for r in CURRENT]),
                None,
                Form.DIFFERENCE,
            ),
        ),
        rule="the margin of two visits over one, averaged over FORMER and REMOVED, exceeds its average over the other four",
        holds=lambda q: q["past"] > q["current"],
    ),
    Statement(
        key="same_maps_read_twice",
        claim=(
            "With grounding handed over, reading the maps as two visits lifts the total, but FORMER and REMOVED do not "
            "recover: the gain is on relations that leave an object to find."
        ),
        quantities=tuple(
            Quantity(
                f"{memory}_{relation}",
                f"{relation.upper()}, {words}",
                static(f"grounding_{arm}", relation),
                f"static.grounding_{arm}.{relation}",
            )
            for relation in (ALL, *PAST)
            for memory, arm, words in (("two", TWO, "two visits"), ("one", ONE, "one visit"))
        ),
        rule=f"two visits are ahead over all episodes, and by at most {NEGLIGIBLE} on FORMER and on REMOVED",
        holds=lambda q: q["two_all"] > q["one_all"] and all(q[f"two_{r}"] - q[f"one_{r}"] <= NEGLIGIBLE for r in PAST),
    ),
    ahead_embodied(
        "two_beat_one_embodied",
        "When both navigate, two visits beat one.",
        ONE_EMBODIED,
        ("embodied_wins", "embodied_losses", "embodied_p_all"),
    ),
    Statement(
        key="only_removed_survives_embodied",
        claim="When both navigate, of the six relations only REMOVED survives the correction.",
        quantities=tuple(
            Quantity(
                relation,
                f"{relation.upper()}, corrected p",
                compared(TWO_EMBODIED, ONE_EMBODIED, "p_holm", relation),
                f"embodied_p_{relation}" if relation in PAST else None,
                Form.P,
            )
            for relation in (*reversed(PAST), *CURRENT)
        ),
        rule=f"the corrected p of REMOVED is below {ALPHA}, that of every other relation is not (first seed)",
        holds=_only_removed_survives,
    ),
    Statement(
        key="ahead_under_every_seed",
        claim="Under each of three seeds the agent with two visits is ahead when navigating, and seeds spread little.",
        quantities=tuple(
            Quantity(
                f"{memory}_{seed}",
                f"{words}, seed {seed + 1}",
                navigated(arm, "sr", seed),
                f"{paper}_seed_{seed}",
            )
            for memory, arm, words, paper in (
                ("two", TWO_EMBODIED, "two visits", "two_visits"),
                ("one", ONE_EMBODIED, "one visit", "single_visit"),
            )
            for seed in SEEDS
        )
        + tuple(
            Quantity(f"margin_{name}", f"{name} margin", margin, f"embodied_margin_{name}", Form.DIFFERENCE, decides=False)
            for name, margin in (("least", lowest(_MARGINS)), ("greatest", highest(_MARGINS)))
        ),
        rule=f"two visits are ahead under each seed, and neither arm spreads over more than {NEGLIGIBLE}",
        holds=lambda q: (
            all(q[f"two_{seed}"] > q[f"one_{seed}"] for seed in SEEDS)
            and all(_spread(q, memory) <= NEGLIGIBLE for memory in ("one", "two"))
        ),
    ),
)


def _spread(q: Mapping[str, float], memory: str) -> float:
    rates = [q[f"{memory}_{seed}"] for seed in SEEDS]
    return max(rates) - min(rates)
