"""Statements of the paper about where the difficulty lies."""

from __future__ import annotations

from ovman.report.paper import COUNT, DIFFERENCE
from ovman.report.statements.readings import GROUNDING
from ovman.report.statements.statement import FAILS, SOME, Evidence, Explanation, Group

GROUP = Group("Where the difficulty lies")


@GROUP.statement(
    "Given true positions, the decision rules answer nearly every episode; they are not the obstacle.",
    holds_if="both rates are at least 0.97",
)
def positions_solve_it(here: Evidence) -> bool:
    return min(here.use_static("static", "positions_two"), here.use_embodied("navigating", "positions_two")) >= 0.97


@GROUP.statement(
    "Oracle grounding does not hurt.",
    holds_if="the rate with oracle grounding is at least that with the agent's own",
    readings=GROUNDING,
)
def grounding_helps(here: Evidence) -> bool:
    handed, own = here.use_static("oracle grounding", "grounding_two"), here.use_static("own grounding", "two")
    here.explanation = Explanation(
        SOME,
        f"""By majority success is {handed} instead of {own}: an object with fewer detections of the target than of its neighbours
        is not a candidate, although the mean of its features can be similar enough to the noun.""",
        under=("any", "nearest"),
        given=handed < own,
    )
    return handed >= own


@GROUP.statement(
    "The gain from oracle grounding is not significant.", holds_if="the exact p is at least 0.05", readings=GROUNDING
)
def grounding_is_not_significant(here: Evidence) -> bool:
    rows = here.rows("readings", arm="static.grounding_two")
    wins = here.show("episodes gained", rows.one("gained"), "handover_wins")
    losses = here.show("episodes lost", rows.one("lost"), "handover_losses")
    p = here.use("exact p", rows.one("p"), "handover_p")
    by_any, by_nearest = (here.static(f"grounding_two_{name}").one() for name in ("any", "nearest"))
    here.explanation = Explanation(
        SOME,
        f"""By majority {wins} episodes are gained and {losses} lost (the paper: {here.quote("handover_wins", COUNT)} and
        {here.quote("handover_losses", COUNT)}); neither difference is significant, since true names do not separate instances
        that the map has joined. The other readings also forgive faults of the map: they give the agent an object with one
        detection of the target, or one within a metre of it, although most of it is something else. Under them success is
        {by_any} and {by_nearest}.""",
        under=("majority",),
    )
    return p >= 0.05


@GROUP.statement(
    "The difficulty lies in the map (where things are, and which is which across visits), not in naming the object.",
    holds_if="the rung of mapping is larger than that of grounding and that of selection",
    readings=GROUNDING,
)
def mapping_is_the_largest_rung(here: Evidence) -> bool:
    positions, handed, own = (here.static(row).one() for row in ("positions_two", "grounding_two", "two"))
    mapping = here.use("mapping", positions - handed, "rung_mapping")
    grounding = here.use("grounding", handed - own, "rung_grounding")
    selection = here.use("selection", here.rows("budget", rung="answer given").one("gain"), "rung_selection")
    by_any, by_nearest = (here.static(f"grounding_two_{name}").one() for name in ("any", "nearest"))
    here.explanation = Explanation(
        SOME,
        f"""The reading decides what counts as a fault of the map. By majority only the names are given, and mapping costs
        {mapping} (the paper: {here.quote("rung_mapping", DIFFERENCE)}): objects that hold a neighbour's detections, targets in no
        detection, false pairs. Giving every object with one right detection leaves {positions - by_any} to mapping, still the
        largest rung. The nearest object hides nearly all of these faults (success {by_nearest} of {positions} with positions),
        and the rung of grounding includes them.""",
        under=("any", "majority"),
        given=mapping > 0 and by_any < by_nearest,
    )
    return mapping > max(grounding, selection)


@GROUP.statement("Selecting the answer, once positions are known, costs almost nothing.", holds_if="it costs at most 0.02")
def selection_is_free(here: Evidence) -> bool:
    selection = here.use("selection", here.rows("budget", rung="answer given").one("gain"), "rung_selection")
    moving = here.static("positions_two", "moving").one()
    others = here.static("positions_two", ("moved", "former", "stable", "appeared", "removed")).lowest()
    here.explanation = Explanation(
        FAILS,
        f"""All of it is MOVING ({moving} with oracle positions; {others} at least on every other relation): a mover that turns
        back is recorded at places that spread by less than tau_trk, and the rule abstains.""",
        given=moving < 1.0 == others,
        episodes=("FloorPlan227/moving/0027", "FloorPlan311/moving/0011", "FloorPlan318/moving/0037"),
    )
    return selection <= 0.02


@GROUP.statement(
    "With oracle positions, executing the plan costs almost nothing.", holds_if="static minus embodied success is at most 0.02"
)
def navigation_is_free(here: Evidence) -> bool:
    cost = here.static("positions_two").one() - here.embodied("positions_two").one()
    return here.use("navigation", cost, "rung_navigation") <= 0.02


@GROUP.statement(
    "The oracle completes every episode but for movers, which are stochastic.",
    holds_if="its rate is 1 on every relation except MOVING, and at least 0.97 over all",
)
def oracle_fails_only_on_movers(here: Evidence) -> bool:
    relations = ("all", "moved", "former", "moving", "stable", "appeared", "removed")
    rates = {relation: here.use_embodied(relation.upper(), "oracle", relation) for relation in relations}
    over_all, _ = rates.pop("all"), rates.pop("moving")
    return over_all >= 0.97 and min(rates.values()) == 1.0


@GROUP.statement(
    "The two-visit agent succeeds about as often when it navigates as on the static gate.",
    holds_if="the two rates are at most 0.05 apart",
)
def embodied_is_near_static(here: Evidence) -> bool:
    return abs(here.use_embodied("navigating", "two") - here.use_static("static", "two")) <= 0.05


@GROUP.statement(
    "Navigating wins more episodes than it loses, since the stop test accepts places near the object's box.",
    holds_if="more runs are gained than lost",
)
def embodied_exceeds_static(here: Evidence) -> bool:
    rows = here.rows("navigation", arm="embodied.two")
    gained = here.use("gained, mean of seeds", rows.mean("gained"), "gained_by_navigating")
    lost = here.use("lost, mean of seeds", rows.mean("lost"), "lost_by_navigating")
    return gained > lost


@GROUP.statement(
    "What navigating gains are stops within R of the object's box, where the predicted point lies farther than that from the "
    "answer; mostly on MOVING and STABLE.",
    holds_if="more than half of the runs gained are rescued, and more than half of the rescued are of the two relations",
)
def rescued_next_to_the_box(here: Evidence) -> bool:
    rows, on_moving, on_stable = (
        here.rows("rescued", arm="embodied.two", relation=relation) for relation in ("all", "moving", "stable")
    )
    rescued = here.use("rescued, mean of seeds", rows.mean("rescued"), "rescued_stops")
    gained = here.use("of runs gained", rows.mean("gained"), "gained_by_navigating")
    moving = here.use("MOVING", on_moving.mean("rescued"))
    stable = here.use("STABLE", on_stable.mean("rescued"))
    return rescued > 0.5 * gained and moving + stable > 0.5 * rescued


@GROUP.statement("Where the two-visit agent succeeds, its path is near-optimal.", holds_if="SPL given success is at least 0.9")
def paths_are_near_optimal(here: Evidence) -> bool:
    rows = here.rows("navigation", arm="embodied.two")
    return here.use("SPL given success", rows.mean("spl_given_success"), "spl_given_success") >= 0.9
