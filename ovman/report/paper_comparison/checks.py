"""Statements on language and on the back-projection's self-check (Sections "Validity checks" and "Reference agent")."""

from __future__ import annotations

from ovman.analysis.language import What
from ovman.report.paper_comparison.sources import language, self_checked, worst_m
from ovman.report.paper_comparison.statement import Form, Quantity, Statement

UNDERSTOOD = 0.9
UNCHANGED = 0.01
SUCCESS_RADIUS_M = 1.0

STATEMENTS: tuple[Statement, ...] = (
    Statement(
        key="held_out_phrasings_are_parsed",
        claim="The parser reads object and relation of held-out phrasings right nearly always.",
        quantities=(Quantity("both", "object and relation", language(What.BOTH.value), "parser_accuracy"),),
        rule=f"both are right for at least {UNDERSTOOD} of the held-out sentences",
        holds=lambda q: q["both"] >= UNDERSTOOD,
    ),
    Statement(
        key="inferred_equals_supplied",
        claim="Success is the same whether the relation is supplied or inferred from the sentence.",
        quantities=(
            Quantity("supplied", "relation supplied", language(What.SUPPLIED.value), "success_supplied"),
            Quantity("inferred", "relation inferred", language(What.RELATION_INFERRED.value), "success_inferred"),
        ),
        rule=f"the two rates are at most {UNCHANGED} apart",
        holds=lambda q: abs(q["supplied"] - q["inferred"]) <= UNCHANGED,
    ),
    Statement(
        key="single_rays_err",
        claim="A single ray at a mask's median depth can miss its object by metres; the median of the mask's points does not.",
        quantities=(
            Quantity("ray", "worst single ray", worst_m("ray_box_m"), "single_ray_worst_m", Form.METRES),
            Quantity("median", "worst median", worst_m("median_box_m"), None, Form.METRES),
            Quantity("objects", "objects", self_checked("scene", "object"), "self_check_objects", Form.COUNT, decides=False),
            Quantity("scenes", "scenes", self_checked("scene"), "self_check_scenes", Form.COUNT, decides=False),
        ),
        rule=f"off the object's box, the worst single ray lies more than {SUCCESS_RADIUS_M} m and farther than the worst median",
        holds=lambda q: q["ray"] > max(SUCCESS_RADIUS_M, q["median"]),
    ),
)
