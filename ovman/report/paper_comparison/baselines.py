"""Statements on the published systems (Section "Do the existing paradigms fail, and why?", and the validity checks on them)."""

from __future__ import annotations

from collections.abc import Mapping

from ovman.report.paper_comparison.memory import ALPHA, NEGLIGIBLE, ONE, OVERALL, TWO, TWO_EMBODIED, ahead_embodied
from ovman.report.paper_comparison.sources import (
    ALL,
    CURRENT,
    PAST,
    Read,
    embodied,
    least_p_ahead,
    less,
    mean,
    mean_of_seeds,
    objects,
    of_pairings,
    of_seeds,
    own_task,
    own_task_p,
    static,
)
from ovman.report.paper_comparison.statement import Form, Quantity, Statement

COW = "cow"
MAINTAINED, TWICE = "dualmap_maintained", "dualmap_two_visits"
READINGS = {MAINTAINED: "maintained map", TWICE: "read as two visits"}
HANDED = "grounding_"
ALMOST_NEVER = 0.1
HALF = 0.5
# Two readings of the same maps, by the system whose maps they are: the one of two visits, then the current-state one.
MAPPINGS = {"ours": (f"{HANDED}{TWO}", f"{HANDED}{ONE}"), "dualmap": (f"{HANDED}{TWICE}", f"{HANDED}{MAINTAINED}")}


def _gain(mapping: str, relations: tuple[str, ...]) -> Read:
    two, one = MAPPINGS[mapping]
    return mean([less(static(two, relation), static(one, relation)) for relation in relations])


def _gains_where_an_object_is_left(q: Mapping[str, float]) -> bool:
    return all(q[f"{name}_current"] > max(0.0, q[f"{name}_past"]) and q[f"{name}_past"] <= NEGLIGIBLE for name in MAPPINGS)


STATEMENTS: tuple[Statement, ...] = (
    ahead_embodied(
        "two_visits_beat_cow",
        "The agent with two visits beats CoW, which sees one.",
        COW,
        ("cow_wins", "cow_losses", "cow_p"),
        (
            Quantity("two", "two visits", embodied(TWO_EMBODIED), f"embodied.{TWO_EMBODIED}.all", decides=False),
            Quantity("cow", "CoW", embodied(COW), f"embodied.{COW}.all", decides=False),
        ),
    ),
    Statement(
        key="vacated_places_are_out_of_reach",
        claim="A single-visit navigator almost never reaches a vacated place.",
        quantities=(
            Quantity("former", "CoW, FORMER", mean_of_seeds(COW, "former"), "cow_former_over_seeds"),
            Quantity("removed", "CoW, REMOVED", embodied(COW, "removed"), f"embodied.{COW}.removed"),
        ),
        rule=f"its success, the mean over the seeds, is at most {ALMOST_NEVER} on FORMER and on REMOVED",
        holds=lambda q: max(q["former"], q["removed"]) <= ALMOST_NEVER,
    ),
    Statement(
        key="its_own_task_is_easier",
        claim=(
            "On its own task, reaching any instance of the category, CoW does much better in the same runs; the gap is the rule "
            "against shortcuts."
        ),
        quantities=(
            Quantity("own", "own task", own_task(COW, "own_rate"), "cow_any_instance"),
            Quantity("here", "this task", own_task(COW, "rate"), f"embodied.{COW}.all"),
            Quantity("p", "largest p of the seeds", own_task_p(COW), None, Form.P),
        ),
        rule=f"its success on its own task is higher, and the exact p of the same runs is below {OVERALL} under every seed",
        holds=lambda q: q["own"] > q["here"] and q["p"] < OVERALL,
    ),
    Statement(
        key="cow_seeds_spread_little",
        claim="CoW's success differs little between three seeds.",
        quantities=(
            Quantity("least", "least of a seed", of_seeds(COW, min), "cow_least"),
            Quantity("greatest", "greatest of a seed", of_seeds(COW, max), "cow_greatest"),
            Quantity("former_least", "FORMER, least", of_seeds(COW, min, "former"), "cow_former_least", decides=False),
            Quantity("former_greatest", "FORMER, greatest", of_seeds(COW, max, "former"), "cow_former_greatest", decides=False),
        ),
        rule=f"the best seed is at most {NEGLIGIBLE} above the worst",
        holds=lambda q: q["greatest"] - q["least"] <= NEGLIGIBLE,
    ),
    Statement(
        key="two_visits_beat_dualmap",
        claim="With its own grounding, DualMap answers fewer episodes than the agent with two visits, however its maps are read.",
        quantities=(
            Quantity("two", "two visits", static(TWO), f"static.{TWO}.all"),
            *(
                Quantity(arm, f"DualMap, {words}", static(arm), f"static.{arm}.all", decides=False)
                for arm, words in READINGS.items()
            ),
            *(
                Quantity(f"{arm}_least", f"least lead over {words}", of_pairings(TWO, arm, min), None, Form.DIFFERENCE)
                for arm, words in READINGS.items()
            ),
            *(
                Quantity(f"{arm}_p", f"largest p, {words}", of_pairings(TWO, arm, max, "p"), None, Form.P)
                for arm, words in READINGS.items()
            ),
        ),
        rule=f"two visits are ahead of each run of each reading, with an exact p below {OVERALL}",
        holds=lambda q: all(q[f"{arm}_least"] > 0 and q[f"{arm}_p"] < OVERALL for arm in READINGS),
    ),
    Statement(
        key="a_maintained_map_answers_the_past_poorly",
        claim="A map that maintains itself answers queries about the past poorly.",
        quantities=tuple(
            Quantity(f"{name}_{relation}", f"{relation.upper()}, {words}", static(arm, relation), f"static.{arm}.{relation}")
            for relation in PAST
            for name, arm, words in (("map", MAINTAINED, "DualMap, maintained map"), ("two", TWO, "two visits"))
        ),
        rule=f"with own grounding, at most {HALF} of what the agent with two visits reaches, on FORMER and on REMOVED",
        holds=lambda q: all(q[f"map_{relation}"] <= HALF * q[f"two_{relation}"] for relation in PAST),
    ),
    Statement(
        key="reading_twice_does_not_recover_the_past",
        claim="Reading DualMap's maps as two visits rather than one does not by itself recover the past relations.",
        quantities=tuple(
            Quantity(
                f"{arm}_{relation}",
                f"{relation.upper()}, {words}",
                static(f"{HANDED}{arm}", relation),
                f"static.{HANDED}{arm}.{relation}",
                decides=relation != ALL,
            )
            for relation in (*PAST, ALL)
            for arm, words in READINGS.items()
        ),
        rule=f"with grounding handed over, two visits are ahead by at most {NEGLIGIBLE} on FORMER and on REMOVED",
        holds=lambda q: all(q[f"{TWICE}_{relation}"] - q[f"{MAINTAINED}_{relation}"] <= NEGLIGIBLE for relation in PAST),
    ),
    Statement(
        key="no_pairing_beats_the_maintained_map",
        claim="Over all relations, too, DualMap's maps read as two visits beat the maintained map under no pairing of the runs.",
        quantities=(
            Quantity(
                "mean",
                "difference of the means",
                less(static(f"{HANDED}{TWICE}"), static(f"{HANDED}{MAINTAINED}")),
                "dualmap_difference",
                Form.DIFFERENCE,
            ),
            *(
                Quantity(
                    f"worst_{relation}",
                    f"worst pairing, {relation.upper()}",
                    of_pairings(f"{HANDED}{TWICE}", f"{HANDED}{MAINTAINED}", min, relation=relation),
                    key,
                    Form.DIFFERENCE,
                    decides=False,
                )
                for relation, key in ((ALL, "dualmap_worst_pairing"), ("former", "dualmap_worst_pairing_former"))
            ),
            Quantity(
                "best",
                "best pairing, ALL",
                of_pairings(f"{HANDED}{TWICE}", f"{HANDED}{MAINTAINED}", max),
                None,
                Form.DIFFERENCE,
                decides=False,
            ),
            Quantity("p", "least p with a lead", least_p_ahead(f"{HANDED}{TWICE}", f"{HANDED}{MAINTAINED}"), None, Form.P),
        ),
        rule=(
            f"with grounding handed over, two visits are ahead by at most {NEGLIGIBLE} on average, and in no pairing of the runs "
            f"with an exact p below {ALPHA}"
        ),
        holds=lambda q: q["mean"] <= NEGLIGIBLE and q["p"] >= ALPHA,
    ),
    Statement(
        key="the_gain_is_where_an_object_is_left",
        claim="What two visits gain over a current-state reading is on the relations that still leave an object to find.",
        quantities=tuple(
            Quantity(f"{name}_{when}", f"{words}, {what}", _gain(name, relations), None, Form.DIFFERENCE)
            for name, words in (("ours", "our maps"), ("dualmap", "DualMap's"))
            for when, what, relations in (("current", "current relations", CURRENT), ("past", "past relations", PAST))
        ),
        rule=(
            "with grounding handed over, on our maps and on DualMap's alike, the mean gain on the four current relations is "
            f"positive and larger than that on FORMER and REMOVED, which is at most {NEGLIGIBLE}"
        ),
        holds=_gains_where_an_object_is_left,
    ),
    Statement(
        key="dualmap_degenerates_in_one_scene",
        claim="In one scene DualMap keeps next to no objects, in all others many.",
        quantities=(
            Quantity("fewest", "objects a map, fewest", objects(0), "dualmap_objects_degenerate", Form.EXPECTED),
            Quantity("second", "second fewest", objects(1), "dualmap_objects_least", Form.EXPECTED),
            Quantity("most", "most", objects(-1), "dualmap_objects_most", Form.EXPECTED, decides=False),
        ),
        rule="the scene with the fewest objects has at most a third of those of the scene with the second fewest",
        holds=lambda q: 3 * q["fewest"] <= q["second"],
    ),
)
