"""Statements on the error budget and on navigation (Section "Where does the remaining difficulty lie?")."""

from __future__ import annotations

from ovman.analysis.comparisons import ANSWER_GIVEN, RUNGS
from ovman.report.paper_comparison.memory import ALPHA, TWO, TWO_EMBODIED
from ovman.report.paper_comparison.sources import ALL, RELATIONS, embodied, less, over_seeds, rung, static
from ovman.report.paper_comparison.statement import Form, Quantity, Statement

GROUNDING, POSITIONS = "grounding_two_visits", "positions_two_visits"
ORACLE_POSITIONS, ORACLE = "two_visits_oracle_positions", "oracle_check"
SOLVED = 0.97
NEXT_TO_NOTHING = 0.02
A_FEW_POINTS = 0.05
NEAR_OPTIMAL = 0.9

_TITLE = {step.arm: step.title for step in RUNGS}
_MAPPING_RUNG, _SELECTION_RUNG = rung(_TITLE[POSITIONS]), rung(ANSWER_GIVEN)
_GROUNDING_RUNG = rung(_TITLE[GROUNDING])

STATEMENTS: tuple[Statement, ...] = (
    Statement(
        key="positions_solve_it",
        claim="Given true positions, the decision rules answer nearly every episode; they are not the obstacle.",
        quantities=(
            Quantity("static", "static", static(POSITIONS), f"static.{POSITIONS}.all"),
            Quantity("embodied", "navigating", embodied(ORACLE_POSITIONS), f"embodied.{ORACLE_POSITIONS}.all"),
        ),
        rule=f"both rates are at least {SOLVED}",
        holds=lambda q: min(q["static"], q["embodied"]) >= SOLVED,
    ),
    Statement(
        key="grounding_helps",
        claim="Handing the grounding over does not hurt.",
        quantities=(
            Quantity("handed", "grounding handed over", static(GROUNDING), f"static.{GROUNDING}.all"),
            Quantity("own", "own grounding", static(TWO), f"static.{TWO}.all"),
        ),
        rule="the rate with grounding handed over is at least that with the agent's own",
        holds=lambda q: q["handed"] >= q["own"],
    ),
    Statement(
        key="grounding_is_not_significant",
        claim="What the handover of grounding gains is not significant.",
        quantities=(
            Quantity("wins", "episodes gained", rung(_TITLE[GROUNDING], "gained"), "handover_wins", Form.COUNT, decides=False),
            Quantity("losses", "episodes lost", rung(_TITLE[GROUNDING], "lost"), "handover_losses", Form.COUNT, decides=False),
            Quantity("p", "exact p", rung(_TITLE[GROUNDING], "p"), "handover_p", Form.P),
        ),
        rule=f"the exact p is at least {ALPHA}",
        holds=lambda q: q["p"] >= ALPHA,
    ),
    Statement(
        key="mapping_is_the_largest_rung",
        claim="The difficulty lies in the map (where things are, and which is which across visits), not in naming the object.",
        quantities=(
            Quantity("mapping", "mapping", _MAPPING_RUNG, "rung_mapping", Form.DIFFERENCE),
            Quantity("grounding", "grounding", _GROUNDING_RUNG, "rung_grounding", Form.DIFFERENCE),
            Quantity("selection", "selection", _SELECTION_RUNG, "rung_selection", Form.DIFFERENCE),
        ),
        rule="the rung of mapping is larger than that of grounding and that of selection",
        holds=lambda q: q["mapping"] > max(q["grounding"], q["selection"]),
    ),
    Statement(
        key="selection_is_free",
        claim="Selecting the answer, once positions are known, costs next to nothing.",
        quantities=(Quantity("selection", "selection", _SELECTION_RUNG, "rung_selection", Form.DIFFERENCE),),
        rule=f"it costs at most {NEXT_TO_NOTHING}",
        holds=lambda q: q["selection"] <= NEXT_TO_NOTHING,
    ),
    Statement(
        key="navigation_is_free",
        claim="With positions handed over, executing the plan costs next to nothing.",
        quantities=(
            Quantity(
                "cost", "navigation", less(static(POSITIONS), embodied(ORACLE_POSITIONS)), "rung_navigation", Form.DIFFERENCE
            ),
        ),
        rule=f"static minus embodied success is at most {NEXT_TO_NOTHING}",
        holds=lambda q: q["cost"] <= NEXT_TO_NOTHING,
    ),
    Statement(
        key="oracle_fails_only_on_movers",
        claim="The oracle completes every episode but for movers, which are stochastic.",
        quantities=tuple(Quantity(r, r.upper(), embodied(ORACLE, r), f"embodied.{ORACLE}.{r}") for r in (ALL, *RELATIONS)),
        rule=f"its rate is 1 on every relation except MOVING, and at least {SOLVED} over all",
        holds=lambda q: q[ALL] >= SOLVED and all(q[r] == 1.0 for r in RELATIONS if r != "moving"),
    ),
    Statement(
        key="embodied_is_near_static",
        claim="The two-visit agent succeeds about as often when it navigates as on the static gate.",
        quantities=(
            Quantity("embodied", "navigating", embodied(TWO_EMBODIED), f"embodied.{TWO_EMBODIED}.all"),
            Quantity("static", "static", static(TWO), f"static.{TWO}.all"),
        ),
        rule=f"the two rates are at most {A_FEW_POINTS} apart",
        holds=lambda q: abs(q["embodied"] - q["static"]) <= A_FEW_POINTS,
    ),
    Statement(
        key="embodied_exceeds_static",
        claim="Navigating wins more episodes than it loses, since the stop test accepts what is near the object's box.",
        quantities=(
            Quantity(
                "gained", "gained, mean of seeds", over_seeds(TWO_EMBODIED, "gained"), "gained_by_navigating", Form.EXPECTED
            ),
            Quantity("lost", "lost, mean of seeds", over_seeds(TWO_EMBODIED, "lost"), "lost_by_navigating", Form.EXPECTED),
        ),
        rule="more runs are gained than lost",
        holds=lambda q: q["gained"] > q["lost"],
    ),
    Statement(
        key="paths_are_near_optimal",
        claim="Where the two-visit agent succeeds, its path is near-optimal.",
        quantities=(Quantity("spl", "SPL given success", over_seeds(TWO_EMBODIED, "spl_given_success"), "spl_given_success"),),
        rule=f"SPL given success is at least {NEAR_OPTIMAL}",
        holds=lambda q: q["spl"] >= NEAR_OPTIMAL,
    ),
)
