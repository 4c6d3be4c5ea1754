"""Statements on how the two-visit agent fails, and on what makes an episode hard (Tables "static" and "taxonomy")."""

from __future__ import annotations

from collections.abc import Mapping

from ovman.report.paper_comparison.memory import ALPHA, TWO
from ovman.report.paper_comparison.sources import (
    EPISODES,
    MORE_INSTANCES,
    RELATIONS,
    THREE_INSTANCES,
    TWO_INSTANCES,
    falling_p,
    of_scenes,
    outcomes,
    share,
    static,
    with_instances,
)
from ovman.report.paper_comparison.statement import Form, Quantity, Statement

FAILURES = ("abstain", "elsewhere", "near_miss", "wrong_instance")
RARELY = 0.05
HALF = 0.5
WITHOUT_FALLBACK = ("appeared", "removed")

_FAILURES = tuple(
    Quantity(failure, failure.replace("_", " "), outcomes(failure), f"taxonomy.{failure}.all", Form.COUNT) for failure in FAILURES
)

STATEMENTS: tuple[Statement, ...] = (
    Statement(
        key="wrong_instances_are_rare",
        claim="The agent rarely lands on another instance of the category.",
        quantities=(
            Quantity("wrong", "wrong instance", outcomes("wrong_instance"), "taxonomy.wrong_instance.all", Form.COUNT),
            Quantity("episodes", "of episodes", outcomes(EPISODES), "taxonomy.episodes.all", Form.COUNT),
        ),
        rule=f"at most {RARELY} of the episodes",
        holds=lambda q: q["wrong"] <= RARELY * q["episodes"],
    ),
    Statement(
        key="abstaining_is_the_commonest_failure",
        claim="Abstaining is the commonest failure.",
        quantities=_FAILURES,
        rule="no other kind of failure is commoner",
        holds=lambda q: all(q["abstain"] >= q[failure] for failure in FAILURES),
    ),
    Statement(
        key="wrong_answers_are_far_off",
        claim="Where the agent answers and fails, it is mostly more than two metres off.",
        quantities=tuple(quantity for quantity in _FAILURES if quantity.name != "abstain"),
        rule="there are more of these than near misses and wrong instances together",
        holds=lambda q: q["elsewhere"] > q["near_miss"] + q["wrong_instance"],
    ),
    Statement(
        key="appeared_and_removed_abstain_most",
        claim="APPEARED and REMOVED, which have no fallback by design, abstain most often.",
        quantities=tuple(Quantity(r, r.upper(), share("abstain", r), None) for r in RELATIONS),
        rule="the share of abstentions on each of the two is larger than on each of the other four relations",
        holds=lambda q: min(q[r] for r in WITHOUT_FALLBACK) > max(value for r, value in q.items() if r not in WITHOUT_FALLBACK),
    ),
    Statement(
        key="stable_is_the_weakest",
        claim="STABLE is the weakest relation on the static gate: its rule commits to a matched pair.",
        quantities=tuple(Quantity(r, r.upper(), static(TWO, r), f"static.{TWO}.{r}") for r in RELATIONS),
        rule="the rate with two visits is lower on STABLE than on each other relation",
        holds=lambda q: q["stable"] < min(value for r, value in q.items() if r != "stable"),
    ),
    Statement(
        key="difficulty_is_not_combinatorial",
        claim="Difficulty is not combinatorial: more instances of the category do not make an episode harder.",
        quantities=(
            Quantity("two", "two instances", with_instances(TWO, TWO_INSTANCES), "success_with_two", decides=False),
            Quantity("three", "three", with_instances(TWO, THREE_INSTANCES), "success_with_three", decides=False),
            Quantity("more", "four or more", with_instances(TWO, MORE_INSTANCES), "success_with_more", decides=False),
            Quantity("p", "p of a fall from two to four or more", falling_p(TWO), None, Form.P),
        ),
        rule=f"success with two instances does not exceed that with four or more (Fisher's exact test, one-sided, at {ALPHA})",
        holds=lambda q: q["p"] >= ALPHA,
    ),
    Statement(
        key="scenes_differ_more",
        claim="Success differs more between scenes than between numbers of instances. (A scene has eleven episodes on average.)",
        quantities=(
            Quantity("worst", "worst scene", of_scenes(TWO, min), "worst_scene"),
            Quantity("best", "best scene", of_scenes(TWO, max), "best_scene"),
            Quantity("two", "two instances", with_instances(TWO, TWO_INSTANCES), "success_with_two"),
            Quantity("three", "three", with_instances(TWO, THREE_INSTANCES), "success_with_three"),
            Quantity("more", "four or more", with_instances(TWO, MORE_INSTANCES), "success_with_more"),
        ),
        rule="the span of the scenes is wider than the span over two, three and four or more instances",
        holds=lambda q: q["best"] - q["worst"] > max(_by_number(q)) - min(_by_number(q)),
    ),
    Statement(
        key="grounding_lifts_every_scene",
        claim="With grounding handed over the agent answers at least half of the episodes of every scene.",
        quantities=(Quantity("worst", "worst scene", of_scenes(f"grounding_{TWO}", min), "worst_scene_grounding"),),
        rule=f"the lowest rate among the scenes is at least {HALF}",
        holds=lambda q: q["worst"] >= HALF,
    ),
)


def _by_number(q: Mapping[str, float]) -> tuple[float, ...]:
    return q["two"], q["three"], q["more"]
