"""Statements of our own about the controls of the config (comparisons.controls); "controls.depth" is the arm of role depth."""

from __future__ import annotations

from ovman.report.metrics import Cell, highest_of, lowest_of
from ovman.report.statements.statement import FAILS, Evidence, Explanation, Group, Margin, above, at_least
from ovman.report.tables.columns import RELATIONS
from ovman.settings import Kind

GROUP = Group("What the paper's own split measures", about_paper=False)
JOINT = Group("What an agent that decides last makes of it", about_paper=False)
"""The agent of role joint weighs all evidence before it decides (docs/joint.md)."""
AGENTS = {
    "two": "reference agent",
    "one": "reference agent, single visit",
    "maintained": "reference agent, maintained map",
    "dualmap_two": "DualMap, two visits",
    "dualmap_one": "DualMap, maintained map",
}


def _rate(here: Evidence, split: str, arm: str, relation: str = "all", kind: Kind = Kind.STATIC) -> Cell:
    """Return the success rate of an agent or a control on a split."""
    return here.rate(kind, arm, relation, split)


@GROUP.statement(
    "On the paper's own split a control that reads no noun and runs no network beats every agent of the paper's kind. The paper "
    "has no such control.",
    holds_if="its rate on the static gate is higher than that of every agent",
)
def no_words_beat_every_agent(here: Evidence) -> Margin:
    depth = here.use("depth difference", _rate(here, "main", "controls.depth"))
    agents = [here.use_static(title, row) for row, title in AGENTS.items()]
    here.show("pixel difference", _rate(here, "main", "controls.pixel"))
    return above(depth, highest_of(agents))


@GROUP.statement(
    "The same control beats every agent when all navigate.", holds_if="its success rate is higher than that of every agent"
)
def no_words_beat_every_agent_that_drives(here: Evidence) -> Margin:
    depth = here.use("depth difference", _rate(here, "main", "controls.depth_driving", kind=Kind.EMBODIED))
    agents = [here.use_embodied(title, row) for row, title in (*list(AGENTS.items())[:2], ("cow", "CoW"))]
    here.show("pixel difference", _rate(here, "main", "controls.pixel_driving", kind=Kind.EMBODIED))
    return above(depth, highest_of(agents))


@GROUP.statement("The reference agent needs the noun.", holds_if="its rate is higher with the noun than with none")
def the_noun_is_needed(here: Evidence) -> Margin:
    given = here.use_static("noun given", "two")
    withheld = here.use("noun withheld", _rate(here, "main", "controls.noun_withheld"))
    here.show("wrong noun", _rate(here, "main", "controls.wrong_noun"))
    return above(given, withheld)


@GROUP.statement("The reference agent needs the relation.", holds_if="its rate is higher than with a drawn relation")
def the_relation_is_needed(here: Evidence) -> Margin:
    given = here.use_static("relation given", "two")
    return above(given, here.use("relation drawn", _rate(here, "main", "controls.relation_withheld")))


@GROUP.statement("The reference agent needs both visits.", holds_if="its rate is higher than with either visit withheld")
def both_visits_are_needed(here: Evidence) -> Margin:
    both = here.use_static("both visits", "two")
    withheld = [here.use(f"{which} withheld", _rate(here, "main", f"controls.{which}_withheld")) for which in ("first", "second")]
    return above(both, highest_of(withheld))


@GROUP.statement(
    "Any instance of the category is the answer no more often than by chance.",
    holds_if="on no relation does it exceed the mean of 1/n",
)
def the_category_alone_is_at_chance(here: Evidence) -> Margin:
    rows = here.rows("controls", split="main", arm="controls.category", relation=RELATIONS)
    return at_least(Cell(0.0, "1/n"), here.use("greatest excess over 1/n", rows.highest("rate - chance")))


@JOINT.statement(
    "In a home where other things change as well, an agent that weighs all evidence and decides last is ahead of the reference "
    "agent, with the same detections.",
    holds_if="its rate on the static gate of everyday is higher",
)
def deciding_last_beats_the_reference(here: Evidence) -> Margin:
    last = here.use("joint agent", _rate(here, "everyday", "controls.joint"))
    two = here.use("reference agent", _rate(here, "everyday", "static.two"))
    here.show("joint agent, main", _rate(here, "main", "controls.joint"))
    here.show("reference agent, main", _rate(here, "main", "static.two"))
    return above(last, two)


@JOINT.statement(
    "The joint agent is ahead of the reference agent when both navigate.", holds_if="its success rate on everyday is higher"
)
def deciding_last_beats_the_reference_driving(here: Evidence) -> Margin:
    last = here.use("joint agent", _rate(here, "everyday", "controls.joint_driving", kind=Kind.EMBODIED))
    return above(last, here.use("reference agent", _rate(here, "everyday", "embodied.two", kind=Kind.EMBODIED)))


@JOINT.statement(
    "On the paper's own split the change is so plain that the noun matters less than where other things change.",
    holds_if="without the noun the joint agent loses less on main than on everyday",
)
def the_noun_decides_on_everyday(here: Evidence) -> Margin:
    def use_fall(split: str) -> Cell:
        given = here.use(f"noun given, {split}", _rate(here, split, "controls.joint"))
        return given - here.use(f"noun withheld, {split}", _rate(here, split, "controls.joint_noun_withheld"))

    on_main, on_everyday = use_fall("main"), use_fall("everyday")
    return above(on_everyday, on_main)


@JOINT.statement(
    "On the paper's own split the joint agent is ahead of the control that reads no word.", holds_if="its rate is higher"
)
def deciding_last_beats_the_control_without_words(here: Evidence) -> Margin:
    last = here.use("joint agent", _rate(here, "main", "controls.joint"))
    return above(last, here.use("depth difference", _rate(here, "main", "controls.depth")))


@JOINT.statement(
    "Where instances of one category change in several ways, APPEARED is hard for the joint agent, too.",
    holds_if="on multi its rate on APPEARED is the lowest of the six relations",
)
def appeared_is_hard_for_the_joint_agent(here: Evidence) -> Margin:
    rates = {relation: here.use(relation.upper(), _rate(here, "multi", "controls.joint", relation)) for relation in RELATIONS}
    removed = rates["removed"]
    here.explanation = Explanation(
        FAILS,
        f"REMOVED is as low ({removed}): which of two similar instances is gone is as hard to tell as which one is new.",
    )
    return above(lowest_of([rate for relation, rate in rates.items() if relation != "appeared"]), rates["appeared"])
