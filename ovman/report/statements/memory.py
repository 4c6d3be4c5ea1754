"""Statements of the paper about two visits against one."""

from __future__ import annotations

from ovman.report.metrics import Cell
from ovman.report.paper import DIFFERENCE, EXPECTED
from ovman.report.statements.readings import CURRENT, ONE_READING, PAST
from ovman.report.statements.statement import (
    FAILS,
    Evidence,
    Explanation,
    Group,
    Margin,
    above,
    is_not_significant,
    is_significant,
)
from ovman.report.tables.columns import RELATIONS
from ovman.settings import Kind

GROUP = Group("Two visits against one")
AHEAD = "the rate with two visits is higher"


@GROUP.statement(
    "With its own perception, the agent that keeps two visits beats the one that keeps a single visit.",
    holds_if=AHEAD,
    listed=True,
)
def two_beat_one(here: Evidence) -> Margin:
    two, one = here.use_static("two visits", "two"), here.use_static("one visit", "one")
    here.show("exact p", here.significance("static.two", "static.one").of_seed(0).one("p"), "static_p_all")
    here.show("successes, two visits", here.rows("static_rates", arm="static.two").one("successes"), "two_successes")
    expected = here.rows("static_rates", arm="static.one").one("successes").written_as(EXPECTED)
    here.show("expected, one visit", expected, "one_expected_successes")
    return above(two, one)


def _compare_on(here: Evidence, relation: str) -> Margin:
    """Compare both rates on a relation and show the p value corrected over the six relations."""
    two, one = here.use_static("two visits", "two", relation), here.use_static("one visit", "one", relation)
    rows = here.significance("static.two", "static.one", relation).of_seed(0)
    here.show("corrected p", rows.one("p_holm"), f"static_p_{relation}")
    return above(two, one)


@GROUP.statement("On REMOVED two visits beat one.", holds_if=AHEAD, listed=True)
def two_beat_one_removed(here: Evidence) -> Margin:
    return _compare_on(here, "removed")


@GROUP.statement("On FORMER two visits beat one.", holds_if=AHEAD, listed=True)
def two_beat_one_former(here: Evidence) -> Margin:
    return _compare_on(here, "former")


@GROUP.statement("On MOVED two visits beat one.", holds_if=AHEAD)
def two_beat_one_moved(here: Evidence) -> Margin:
    return _compare_on(here, "moved")


@GROUP.statement("On MOVING two visits beat one.", holds_if=AHEAD, listed=True)
def two_beat_one_moving(here: Evidence) -> Margin:
    margin = _compare_on(here, "moving")
    mover = here.rows("mover", phase="between the visits")
    median, within = mover.one("median_m"), mover.one("within")
    gate = here.rows("gate_sweep", in_force=1).one("gate_m")
    here.explanation = Explanation(
        FAILS,
        f"""Our mover is slow: between the visits it moves {median} (median), and at most R in {within} of the episodes. A pick
        among the places where one visit saw it is seldom far off. The rule for two visits needs an object without a match, and
        an object that moved less than gamma ({gate}) is matched with itself. The paper does not say how its mover walks.""",
        measured=(median, within),
        given=median < gate,
    )
    return margin


@GROUP.statement("On APPEARED two visits are ahead, if only just.", holds_if=AHEAD)
def two_are_just_ahead_on_appeared(here: Evidence) -> Margin:
    return _compare_on(here, "appeared")


@GROUP.statement(
    "On STABLE, which a single visit can in principle read off, a second visit gains nothing significant.",
    holds_if="the corrected p is at least 0.05",
    listed=True,
)
def stable_gains_nothing(here: Evidence) -> Margin:
    here.use_static("two visits", "two", "stable", decides=False)
    here.use_static("one visit", "one", "stable", decides=False)
    p = here.use("corrected p", here.p(Kind.STATIC, "static.two", "static.one", "stable"), "static_p_stable")
    return is_not_significant(p)


@GROUP.statement(
    "Memory is worth most where the answer is a place of the past.",
    holds_if="the margin of two visits over one, averaged over FORMER and REMOVED, exceeds its average over the other four",
    listed=True,
)
def memory_is_largest_on_the_past(here: Evidence) -> Margin:
    past, current = (here.static("two", of) - here.static("one", of) for of in (PAST, CURRENT))
    return above(here.use("mean margin, past relations", past), here.use("mean margin, others", current))


@GROUP.statement(
    "With oracle grounding, reading the maps as two visits lifts the total, but not by FORMER and REMOVED.",
    holds_if="two visits are ahead over all episodes, and their mean gain on the four current relations exceeds that on FORMER "
    "and REMOVED",
    readings=ONE_READING,
    listed=True,
)
def same_maps_read_twice(here: Evidence) -> tuple[Margin, ...]:
    def use(name: str, relation: str) -> tuple[Cell, Cell]:
        one = here.static("grounding_maintained", relation)
        return (
            here.use_static(f"{name}, two visits", "grounding_two", relation, decides=relation == "all"),
            here.use(f"{name}, one map", one, f"static.grounding_one.{relation}", decides=relation == "all"),
        )

    two_all, one_all = use("ALL", "all")
    two_former, one_former = use("FORMER", "former")
    use("REMOVED", "removed")
    past, current = (here.static("grounding_two", of) - here.static("grounding_maintained", of) for of in (PAST, CURRENT))
    past, current = here.use("mean gain, past relations", past), here.use("mean gain, others", current)
    objects = here.rows("fragments", relation="former").one("objects")
    here.explanation = Explanation(
        FAILS,
        f"""Two visits tell which place has no match, since a target falls into only {objects} objects of its map. They answer
        {two_former} of FORMER, and one map, which picks among all places, {one_former}. The paper's detector is not trained on
        its simulator, so its maps may be less clean.""",
        given=objects < 2,
    )
    return above(two_all, one_all), above(current, past)


@GROUP.statement(
    "When both navigate, two visits beat one.",
    holds_if="the success rate with two visits is higher, mean over the seeds",
    listed=True,
)
def two_beat_one_embodied(here: Evidence) -> Margin:
    two, one = here.use_embodied("two visits", "two"), here.use_embodied("one visit", "one")
    rows = here.significance("embodied.two", "embodied.one")
    here.show("wins", rows.of_seed(0).one("wins"), "embodied_wins")
    here.show("losses", rows.of_seed(0).one("losses"), "embodied_losses")
    here.show("largest p of the seeds", rows.highest("p"), "embodied_p_all")
    return above(two, one)


@GROUP.statement(
    "When both navigate, of the six relations only REMOVED survives the correction.",
    holds_if="the corrected p of REMOVED is below 0.05, that of every other relation is not (first seed)",
)
def only_removed_survives_embodied(here: Evidence) -> list[Margin]:
    printed = {"removed": "embodied_p_removed", "former": "embodied_p_former"}
    margins = []
    for relation in RELATIONS:
        p = here.p(Kind.EMBODIED, "embodied.two", "embodied.one", relation)
        p = here.use(f"{relation.upper()}, corrected p", p, printed.get(relation, ""))
        margins.append(is_significant(p) if relation == "removed" else is_not_significant(p))
    median = here.rows("mover", phase="between the visits").one("median_m")
    here.explanation = Explanation(
        FAILS,
        f"""FORMER survives as well, and MOVING does the other way round: one visit is ahead, since our mover is slow, {median}
        between the visits (median).""",
        measured=(median,),
    )
    return margins


@GROUP.statement(
    "Under each of three seeds the agent with two visits is ahead when navigating.",
    holds_if="two visits are ahead under each seed",
)
def ahead_under_every_seed(here: Evidence) -> list[Margin]:
    def use(arm: str, label: str) -> list[Cell]:
        return [
            here.use(f"{label}, seed {number + 1}", here.embodied(arm, seed=seed), f"{arm}_seed_{number}")
            for number, seed in enumerate(here.seeds(f"embodied.{arm}", 3))
        ]

    margins = [above(of_two, of_one) for of_two, of_one in zip(use("two", "two visits"), use("one", "one visit"), strict=True)]
    leads = [float(margin.by) for margin in margins]
    here.show("least margin", Cell(min(leads), "least of the seeds", DIFFERENCE), "embodied_margin_least")
    here.show("greatest margin", Cell(max(leads), "greatest of the seeds", DIFFERENCE), "embodied_margin_greatest")
    return margins
