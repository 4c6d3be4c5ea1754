"""Statements of the paper's validity checks."""

from __future__ import annotations

from ovman.report.metrics import Cell
from ovman.report.paper import COUNT, DIFFERENCE, P
from ovman.report.statements.statement import FAILS, Evidence, Explanation, Group, Margin, above, at_least, is_not_significant
from ovman.report.tables.columns import RELATIONS

GROUP = Group("Validity checks")


@GROUP.statement(
    "The parser reads object and relation of at least 0.941 of held-out phrasings right.",
    holds_if="both are right for at least the paper's share",
    listed=True,
)
def held_out_phrasings_are_parsed(here: Evidence) -> Margin:
    rows = here.rows("language", what="both")
    both = here.use("object and relation", here.share(rows, "count", "n"), "parser_accuracy")
    unread = here.rows("language", what="read_as", read_as=("no_relation", "ambiguous_relation")).sum("count")
    here.explanation = Explanation(
        FAILS,
        f"""Its grammar lacks cues: it refuses {unread} of {rows.one("n")} sentences, in which it finds no relation or several.
        The sentences were written by someone who had not seen the parser.""",
        measured=(unread,),
    )
    return at_least(both, 0.941)


@GROUP.statement(
    "The only confusions of the parser are REMOVED read as FORMER.",
    holds_if="no other relation is read as another",
    listed=True,
)
def only_removed_is_read_as_former(here: Evidence) -> Margin:
    frame = here.metrics.frame("language")
    wrong = frame[(frame["what"] == "read_as") & frame["read_as"].isin(RELATIONS) & (frame["relation"] != frame["read_as"])]
    wrong = wrong[wrong["relation"].isin(RELATIONS)]
    is_excused = (wrong["relation"] == "removed") & (wrong["read_as"] == "former")
    excused, others = (float(wrong.loc[chosen, "count"].sum()) for chosen in (is_excused, ~is_excused))
    here.show("REMOVED read as FORMER", Cell(excused, "language.csv (read_as, removed, former): count", COUNT))
    here.explanation = Explanation(
        FAILS, "Sentences of FORMER that also speak of the move are read as MOVED. They are not the paper's."
    )
    counted = here.use("other confusions", Cell(others, "language.csv (read_as, other relations): count", COUNT))
    return at_least(Cell(0.0, "0"), counted)


@GROUP.statement(
    "Success is the same whether the relation is supplied or inferred from the sentence, which names the object in either case.",
    holds_if="the two rates do not differ with an exact p below 0.05; the least p that the counts allow",
)
def inferred_equals_supplied(here: Evidence) -> Margin:
    supplied, inferred = (here.rows("language", what=what) for what in ("noun_inferred", "inferred"))
    here.show("relation supplied", supplied.one(), "success_supplied")
    here.show("relation inferred", inferred.one(), "success_inferred")
    apart = abs(supplied.one("count") - inferred.one("count"))
    return is_not_significant(here.use("least p", Cell(min(1.0, 2.0 ** (1.0 - apart)), "two-sided, all discordant one way", P)))


@GROUP.statement(
    "REMOVED read as FORMER resolves to the same place.",
    holds_if="every answer to an episode of REMOVED is the same when it is read as FORMER",
)
def read_as_former_is_the_same_place(here: Evidence) -> Margin:
    rows = here.rows("read_as", relation="removed")
    answered = here.use("REMOVED answered", rows.one("answered"))
    same = here.use("the same read as FORMER", rows.one("same"))
    here.show("answered as FORMER alone", rows.one("only_read_as"))
    return at_least(same, answered)


@GROUP.statement(
    "The static margin of memory never changes its sign, wherever the thresholds of admissibility are set.",
    holds_if="the least margin is above 0, over the trials admitted and over the released episodes that are left",
    listed=True,
)
def margin_keeps_its_sign(here: Evidence) -> tuple[Margin, ...]:
    rows = here.rows("sensitivity", in_force=0)
    here.show("settings", rows.count_distinct("setting"), "admissibility_settings")
    here.show("different sets of trials", rows.count_distinct("episodes", "margin", "released", "released_margin"))
    least = here.use("least margin", rows.lowest("margin"), "static_margin_least")
    here.show("greatest", rows.highest("margin"), "static_margin_greatest")
    released = here.use("least, released episodes", rows.lowest("released_margin"))
    here.show("greatest, released episodes", rows.highest("released_margin"))
    return above(least, 0.0), above(released, 0.0)


@GROUP.statement(
    "The static margin of memory hardly depends on where the thresholds of admissibility are set.",
    holds_if="within the measured tolerances of the thresholds its span is below the margin in force",
    listed=True,
)
def margin_hardly_varies(here: Evidence) -> Margin:
    rows = here.rows("tolerances", in_force=0)
    least, greatest = rows.lowest("margin"), rows.highest("margin")
    here.show("least margin", least, "static_margin_least")
    here.show("greatest", greatest, "static_margin_greatest")
    span = here.use("span", Cell(greatest - least, "tolerances.csv: greatest − least", DIFFERENCE))
    here.show("settings", rows.count_distinct("setting"), "admissibility_settings")
    return above(here.use("margin in force", here.rows("tolerances", in_force=1).one("margin")), span)


@GROUP.statement(
    "A single ray at a mask's median depth can miss its object by more than the median of the mask's points does.",
    holds_if="off the object's box, the worst single ray lies farther than the worst median",
)
def single_rays_err(here: Evidence) -> Margin:
    rows = here.rows("backprojection", mask="true")
    ray = here.use("worst single ray", rows.highest("ray_box_m"), "single_ray_worst_m")
    median = here.use("worst median", rows.highest("median_box_m"))
    here.show("objects", rows.count_distinct("scene", "object"), "self_check_objects")
    here.show("scenes", rows.count_distinct("scene"), "self_check_scenes")
    return above(ray, median)
