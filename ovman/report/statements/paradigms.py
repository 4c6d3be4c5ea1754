"""Statements of the paper about CoW and DualMap."""

from __future__ import annotations

from ovman.report.metrics import Cell, highest_of, lowest_of
from ovman.report.paper import COUNT, DIFFERENCE
from ovman.report.statements.readings import CURRENT, GROUNDING, ONE_READING, PAST
from ovman.report.statements.statement import FAILS, Evidence, Explanation, Group, Margin, above, at_least
from ovman.settings import Kind

GROUP = Group("Do the existing paradigms fail, and why?")


@GROUP.statement(
    "The agent with two visits beats CoW, which sees one.",
    holds_if="its success rate is higher, mean over the seeds",
    listed=True,
)
def two_visits_beat_cow(here: Evidence) -> Margin:
    two, cow = here.use_embodied("two visits", "two"), here.use_embodied("CoW", "cow")
    rows = here.significance("embodied.two", "embodied.cow")
    here.show("wins", rows.of_seed(0).one("wins"), "cow_wins")
    here.show("losses", rows.of_seed(0).one("losses"), "cow_losses")
    here.show("largest p of the seeds", rows.highest("p"), "cow_p")
    return above(two, cow)


@GROUP.statement(
    "A single-visit navigator reaches vacated places least.",
    holds_if="CoW's success on FORMER, and that on REMOVED, is below its mean on the other four relations",
    listed=True,
)
def vacated_places_are_out_of_reach(here: Evidence) -> tuple[Margin, ...]:
    former = here.use("CoW, FORMER", here.embodied("cow", "former"), "cow_former_over_seeds")
    removed = here.use_embodied("CoW, REMOVED", "cow", "removed")
    others = here.use("CoW, mean of the others", here.embodied("cow", CURRENT))
    return above(others, former), above(others, removed)


@GROUP.statement(
    "On its own task, reaching any instance of the category, CoW does better in the same runs; the gap is the rule against "
    "shortcuts.",
    holds_if="its success on its own task is higher",
)
def its_own_task_is_easier(here: Evidence) -> Margin:
    own = here.metrics.sums(Kind.EMBODIED, "embodied.cow", "own_success").mean()
    own, this = here.use("own task", own, "cow_any_instance"), here.use_embodied("this task", "cow")
    here.show("largest p of the seeds", here.rows("own_task", arm="embodied.cow").highest("p"))
    return above(own, this)


@GROUP.statement(
    "CoW's three seeds are so close that none of them changes the comparison with it.",
    holds_if="two visits lead its best seed by more than its best seed leads its worst",
)
def cow_seeds_spread_little(here: Evidence) -> Margin:
    of_seeds = [here.embodied("cow", seed=seed) for seed in here.seeds("embodied.cow", 3)]
    least = here.use("lowest seed", lowest_of(of_seeds), "cow_least")
    greatest = here.use("highest seed", highest_of(of_seeds), "cow_greatest")
    former = here.rows("seeds", arm="embodied.cow", relation="former")
    here.show("FORMER, least", former.lowest(), "cow_former_least")
    here.show("FORMER, greatest", former.highest(), "cow_former_greatest")
    return above(here.use_embodied("two visits", "two") - greatest, greatest - least)


@GROUP.statement(
    "With its own grounding, DualMap answers fewer episodes than the agent with two visits, however its maps are read.",
    holds_if="the rate of the agent is higher than the mean of DualMap's runs, under either way to read its maps",
    listed=True,
)
def two_visits_beat_dualmap(here: Evidence) -> tuple[Margin, ...]:
    two = here.use_static("two visits", "two")
    one_map = here.use_static("DualMap, maintained map", "dualmap_one")
    two_maps = here.use_static("DualMap, read as two visits", "dualmap_two")
    for title, row in (("maintained map", "dualmap_one"), ("read as two visits", "dualmap_two")):
        rows = here.rows("pairings", arm="static.two", baseline=f"static.{row}")
        here.show(f"largest p, {title}", rows.highest("p"))
    return above(two, one_map), above(two, two_maps)


@GROUP.statement(
    "A map that maintains itself answers queries about the past worse than the agent with two visits.",
    holds_if="with own grounding its rate is lower on FORMER and on REMOVED",
    listed=True,
)
def a_maintained_map_answers_the_past_poorly(here: Evidence) -> list[Margin]:
    return [
        above(
            here.use_static(f"{relation.upper()}, two visits", "two", relation),
            here.use_static(f"{relation.upper()}, DualMap, maintained map", "dualmap_one", relation),
        )
        for relation in PAST
    ]


def _use_both(here: Evidence, relation: str, *, decides: bool = True) -> tuple[Cell, Cell]:
    name = relation.upper()
    return (
        here.use_static(f"{name}, maintained map", "grounding_dualmap_one", relation, decides=decides),
        here.use_static(f"{name}, read as two visits", "grounding_dualmap_two", relation, decides=decides),
    )


@GROUP.statement(
    "Reading DualMap's maps as two visits rather than one does not recover the past relations: the maintained map is ahead.",
    holds_if="with oracle grounding, the maintained map is at least as good on FORMER and on REMOVED",
    readings=GROUNDING,
    listed=True,
)
def reading_twice_does_not_recover_the_past(here: Evidence) -> list[Margin]:
    margins = [at_least(*_use_both(here, relation)) for relation in PAST]
    _use_both(here, "all", decides=False)
    objects = here.rows("dualmap", scene="all", memory="two visits", run="all").one("objects_mean")
    here.explanation = Explanation(
        FAILS,
        f"""Our maps have few objects to confuse, {objects} instead of {here.quote("dualmap_objects_least", COUNT)} to
        {here.quote("dualmap_objects_most", COUNT)}. Read as two visits they tell which place has no match; the maintained map
        picks among the places of both visits. No experiment varied the number of objects.""",
        given=objects < 43,
    )
    return margins


@GROUP.statement(
    "Not every pairing of DualMap's runs has its maps read as two visits ahead of the maintained map.",
    holds_if="with oracle grounding, the worst pairing of the runs has no lead, over all relations and on FORMER",
    readings=GROUNDING,
)
def no_pairing_beats_the_maintained_map(here: Evidence) -> list[Margin]:
    def worst(relation: str) -> Cell:
        def runs(row: str) -> list[Cell]:
            seeds = here.seeds(f"static.{row}", 1, Kind.STATIC)
            return [here.rate(Kind.STATIC, f"static.{row}", relation, seed=seed) for seed in seeds]

        leads = [two - one for two in runs("grounding_dualmap_two") for one in runs("grounding_dualmap_one")]
        cell = lowest_of(leads)
        return Cell(cell, f"main/static_outcomes.csv, {relation}: least of {len(leads)} pairings", DIFFERENCE, cell.draws)

    difference = here.static("grounding_dualmap_two") - here.static("grounding_dualmap_one")
    here.show("difference of the means", difference, "dualmap_difference")
    over_all = here.use("worst pairing, ALL", worst("all"), "dualmap_worst_pairing")
    on_former = here.use("worst pairing, FORMER", worst("former"), "dualmap_worst_pairing_former")
    here.explanation = Explanation(
        FAILS, "The reason is that of the statement before: the maintained map cannot tell the places of the two visits apart."
    )
    return [at_least(Cell(0.0, "0"), cell) for cell in (over_all, on_former)]


@GROUP.statement(
    "What two visits gain over a current-state reading is on the relations that still leave an object to find.",
    holds_if="with oracle grounding, on our maps and on DualMap's alike, the mean gain on the four current relations is larger "
    "than that on FORMER and REMOVED",
    readings=ONE_READING,
)
def the_gain_is_where_an_object_is_left(here: Evidence) -> list[Margin]:
    margins = []
    for whose, two, one in (
        ("our maps", "grounding_two", "grounding_maintained"),
        ("DualMap's", "grounding_dualmap_two", "grounding_dualmap_one"),
    ):
        current, past = (here.static(two, of) - here.static(one, of) for of in (CURRENT, PAST))
        margins.append(above(here.use(f"{whose}, current relations", current), here.use(f"{whose}, past relations", past)))
    here.explanation = Explanation(
        FAILS,
        "The relations of the past gain more, since a map of each visit tells which place was vacated and one map does not.",
    )
    return margins
