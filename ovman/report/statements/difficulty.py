"""Statements of the paper about where the difficulty lies."""

from __future__ import annotations

from ovman.report.metrics import Cell, ratio
from ovman.report.paper import COUNT
from ovman.report.statements.readings import GROUNDING
from ovman.report.statements.statement import (
    FAILS,
    SOME,
    Evidence,
    Explanation,
    Group,
    Margin,
    above,
    at_least,
    is_not_significant,
)
from ovman.report.tables.columns import RELATIONS
from ovman.settings import Kind

GROUP = Group("Where the difficulty lies")
ONE = Cell(1.0, "1")


@GROUP.statement(
    "Given true positions, the decision rules are not the obstacle.",
    holds_if="what they still miss, on the static gate and navigating, is less than what true positions gain",
    listed=True,
)
def positions_solve_it(here: Evidence) -> list[Margin]:
    static, driven = here.use_static("static", "positions_two"), here.use_embodied("navigating", "positions_two")
    own, own_driven = here.use_static("own positions, static", "two"), here.use_embodied("own positions, navigating", "two")
    return [above(static - own, ONE - static), above(driven - own_driven, ONE - driven)]


@GROUP.statement(
    "Oracle grounding does not hurt.",
    holds_if="the rate with oracle grounding is at least that with the agent's own",
    readings=GROUNDING,
)
def grounding_helps(here: Evidence) -> Margin:
    return at_least(here.use_static("oracle grounding", "grounding_two"), here.use_static("own grounding", "two"))


@GROUP.statement(
    "The gain from oracle grounding is not significant.",
    holds_if="the exact p is at least 0.05",
    readings=GROUNDING,
    listed=True,
)
def grounding_is_not_significant(here: Evidence) -> Margin:
    rows = here.rows("readings", arm="static.grounding_two")
    wins = here.show("episodes gained", rows.one("gained"), "handover_wins")
    losses = here.show("episodes lost", rows.one("lost"), "handover_losses")
    exact = rows.one("p")
    p = here.use("exact p", here.p(Kind.STATIC, "static.grounding_two", "static.two", exact=exact), "handover_p")
    two = here.static("two")
    here.explanation = Explanation(
        FAILS,
        f"""Our encoder names objects less well than the paper's: true names gain {wins} episodes and lose {losses} (the paper:
        {here.quote("handover_wins", COUNT)} and {here.quote("handover_losses", COUNT)}). Of the right detections it ranks the
        right category first in {here.rows("perception", group="all", value="all").one("top1")}. The paper does not print its
        encoder's rate, so the comparison with it is a guess.""",
        given=wins > losses and two > 0.0,
    )
    return is_not_significant(p)


@GROUP.statement(
    "The difficulty lies in the map, not in naming the object.",
    holds_if="the rung of mapping is larger than that of grounding and that of selection",
    readings=GROUNDING,
    listed=True,
)
def mapping_is_the_largest_rung(here: Evidence) -> tuple[Margin, ...]:
    positions, handed, own = (here.static(row) for row in ("positions_two", "grounding_two", "two"))
    mapping = here.use("mapping", positions - handed, "rung_mapping")
    grounding = here.use("grounding", handed - own, "rung_grounding")
    selection = here.use("selection", ONE - positions, "rung_selection")
    nearest = here.static("grounding_two_nearest")
    here.explanation = Explanation(
        SOME,
        f"""The nearest object to each true place hides wrong places and joined objects, too: success is {nearest}. By majority
        only the names are given.""",
        measured=(nearest,),
        under=("majority",),
    )
    return above(mapping, grounding), above(mapping, selection)


@GROUP.statement(
    "Selecting the answer, once positions are known, costs least of the three rungs.",
    holds_if="it costs less than grounding and less than mapping",
    readings=GROUNDING,
)
def selection_costs_least(here: Evidence) -> tuple[Margin, ...]:
    positions, handed, own = (here.static(row) for row in ("positions_two", "grounding_two", "two"))
    selection = here.use("selection", ONE - positions, "rung_selection")
    mapping = here.use("mapping", positions - handed, "rung_mapping")
    return above(mapping, selection), above(here.use("grounding", handed - own, "rung_grounding"), selection)


@GROUP.statement(
    "With oracle positions, executing the plan costs almost nothing.",
    holds_if="it costs less than perceiving, which is the gap between true and own positions on the static gate",
)
def navigation_is_free(here: Evidence) -> Margin:
    cost = here.use("navigation", here.static("positions_two") - here.embodied("positions_two"), "rung_navigation")
    return above(here.use("perceiving", here.static("positions_two") - here.static("two")), cost)


@GROUP.statement(
    "The oracle fails only on movers, which are stochastic.", holds_if="its rate is 1 on every relation except MOVING"
)
def oracle_fails_only_on_movers(here: Evidence) -> list[Margin]:
    here.use_embodied("ALL", "oracle", decides=False)
    rates = {
        relation: here.use_embodied(relation.upper(), "oracle", relation, decides=relation != "moving") for relation in RELATIONS
    }
    return [at_least(rate, ONE) for relation, rate in rates.items() if relation != "moving"]


@GROUP.statement(
    "Navigating wins more episodes than it loses, since the stop test accepts places near the object's box.",
    holds_if="the agent's success when navigating is above that on the static gate",
    listed=True,
)
def embodied_exceeds_static(here: Evidence) -> Margin:
    rows = here.rows("navigation", arm="embodied.two")
    here.show("gained, mean of seeds", rows.mean("gained"), "gained_by_navigating")
    here.show("lost, mean of seeds", rows.mean("lost"), "lost_by_navigating")
    return above(here.use_embodied("navigating", "two"), here.use_static("static", "two"))


@GROUP.statement(
    "What navigating gains are stops within R of the object's box, mostly on MOVING and STABLE.",
    holds_if="most of the runs gained are rescued by the box, and most of the rescued are of the two relations",
)
def rescued_next_to_the_box(here: Evidence) -> tuple[Margin, ...]:
    rows, on_moving, on_stable = (
        here.rows("rescued", arm="embodied.two", relation=relation) for relation in ("all", "moving", "stable")
    )
    rescued = here.use("rescued, mean of seeds", rows.mean("rescued"), "rescued_stops")
    gained = here.use("of runs gained", rows.mean("gained"), "gained_by_navigating")
    moving, stable = here.use("MOVING", on_moving.mean("rescued")), here.use("STABLE", on_stable.mean("rescued"))
    return above(rescued, Cell(gained / 2, "half of the runs gained")), above(
        Cell(moving + stable, "MOVING and STABLE"), Cell(rescued / 2, "half of the rescued")
    )


@GROUP.statement(
    "Where the two-visit agent succeeds, its path is near-optimal.",
    holds_if="its path loses less, relative to the shortest, than the agent loses by failing",
)
def paths_are_near_optimal(here: Evidence) -> Margin:
    spl, success = (here.metrics.sums(Kind.EMBODIED, "embodied.two", column) for column in ("spl", "success"))
    given = here.use("SPL given success", ratio(spl.total(), success.total()), "spl_given_success")
    return above(given, here.use_embodied("success rate", "two"))
