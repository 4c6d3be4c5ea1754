"""The paper's own figures, each with the place it is printed at, and how figures are written, ours and the paper's alike.

Section `paper` of the config says which arm stands next to which row. Only the page of results and the figures use them.
"""

from __future__ import annotations

from collections.abc import Mapping
from enum import StrEnum
from typing import NamedTuple

EMPTY = "—"
SMALLEST_P = 1e-300
"""Below this a p value is written as a bound: it may have been rounded to zero."""
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


class Form(StrEnum):
    """How a figure is written: a rate, a difference of rates, a count, the expectation of one, a p value, or metres."""

    RATE = "rate"
    DIFFERENCE = "difference"
    COUNT = "count"
    EXPECTED = "expected"
    P = "p"
    METRES = "metres"


RATE, DIFFERENCE, COUNT, EXPECTED, P, METRES = Form


class Printed(NamedTuple):
    """A figure of the paper and where it is printed: a value, of which `low` and `high` are equal, or a range.

    A p value that is printed as a bound is the range from 0.
    """

    place: str
    low: float
    high: float

    def write(self, form: Form = RATE) -> str:
        """Return the figure in the form of ours next to it."""
        if self.low == self.high:
            return write(self.low, form)
        return f"{write(self.low, form)} – {write(self.high, form)}" if self.low else f"< {_write_power(self.high)}"


def write(value: float, form: Form = RATE) -> str:
    """Write rates with three decimals, differences with a sign, small p values as powers of ten, metres with their unit."""
    match form:
        case Form.RATE:
            return f"{value:.3f}"
        case Form.DIFFERENCE:
            text = f"{value:+.3f}"
            return text.replace("-", "−") if float(text) else "0.000"
        case Form.COUNT:
            return f"{value:.0f}"
        case Form.EXPECTED:
            return f"{value:.1f}"
        case Form.METRES:
            return f"{value:.1f} m" if value >= 10 else f"{value:.2f} m"
        case Form.P:
            return write_p(value)


def write_p(p: float) -> str:
    """Write 0.032 as it is, 0.00043 as 4.3 × 10⁻⁴, and 0 as a bound."""
    if p < SMALLEST_P:
        return f"< {_write_power(SMALLEST_P)}"
    return f"{p:.3f}" if p >= 0.001 else _write_power(p)


def _write_power(p: float) -> str:
    mantissa, exponent = f"{p:.1e}".replace(".0e", "e").split("e")
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    return power if mantissa == "1" else f"{mantissa} × {power}"


COLUMNS = ("moved", "former", "moving", "stable", "appeared", "removed", "all", "spl")
"""Columns of the paper's tables; a shorter row lacks the last ones."""
TABLES: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "static": {
        "one": (0.230, 0.149, 0.145, 0.223, 0.237, 0.142, 0.186),
        "two": (0.545, 0.447, 0.361, 0.281, 0.375, 0.475, 0.416),
        "grounding_one": (0.369, 0.328, 0.271, 0.358, 0.525, 0.495, 0.396),
        "grounding_two": (0.485, 0.342, 0.500, 0.656, 0.525, 0.400, 0.479),
        "positions_one": (0.389, 0.079, 0.371, 0.500, 0.556, 0.072, 0.321),
        "positions_two": (1.000, 1.000, 0.972, 1.000, 1.000, 1.000, 0.995),
        "dualmap_one": (0.202, 0.158, 0.139, 0.198, 0.133, 0.183, 0.167),
        "dualmap_two": (0.222, 0.193, 0.056, 0.323, 0.292, 0.175, 0.209),
        "grounding_dualmap_one": (0.274, 0.275, 0.321, 0.325, 0.513, 0.395, 0.355),
        "grounding_dualmap_two": (0.424, 0.237, 0.352, 0.292, 0.517, 0.358, 0.365),
    },
    "embodied": {
        "one": (0.424, 0.132, 0.389, 0.375, 0.325, 0.100, 0.283, 0.269),
        "two": (0.576, 0.421, 0.472, 0.406, 0.425, 0.425, 0.452, 0.440),
        "positions_two": (1.000, 0.974, 0.972, 1.000, 1.000, 1.000, 0.991, 0.982),
        "oracle": (1.000, 1.000, 0.972, 1.000, 1.000, 1.000, 0.995, 0.990),
        "cow": (0.121, 0.026, 0.194, 0.219, 0.150, 0.050, 0.123),
    },
    "taxonomy": {
        "success": (18, 17, 13, 9, 15, 19, 91),
        "abstain": (9, 10, 12, 2, 17, 17, 67),
        "elsewhere": (4, 10, 5, 17, 5, 3, 44),
        "near_miss": (1, 0, 3, 3, 2, 0, 9),
        "wrong_instance": (1, 1, 3, 1, 1, 1, 8),
        "episodes": (33, 38, 36, 32, 40, 40, 219),
        "lost_in_navigation": (0, 1, 1, 0, 0, 2, 4),
    },
}
"""Table, row and cells. The key of a cell is "static.two.all"."""
TITLES = {
    "static.one": "one visit",
    "static.two": "two visits",
    "static.grounding_one": "one visit, oracle grounding",
    "static.grounding_two": "two visits, oracle grounding",
    "static.positions_one": "one visit, oracle positions",
    "static.positions_two": "two visits, oracle positions",
    "embodied.one": "one visit",
    "embodied.two": "two visits",
    "embodied.positions_two": "two visits, true positions",
    "embodied.oracle": "oracle",
    "taxonomy.success": "success",
    "taxonomy.abstain": "abstained (no candidate)",
    "taxonomy.elsewhere": "elsewhere (> 2 m)",
    "taxonomy.near_miss": "near miss (1–2 m)",
    "taxonomy.wrong_instance": "wrong instance",
    "taxonomy.episodes": "episodes",
    "taxonomy.lost_in_navigation": "lost in navigation, first seed †",
}
"""Titles of rows; a row without one has the title of the arm that stands next to it."""


IN_TEXT: Mapping[str, Mapping[str, float | tuple[float, float]]] = {
    'Section "Is the task solvable"': {
        "two_successes": 91,
        "one_expected_successes": 40.8,
        "static_p_all": (0.0, 1e-22),
        "static_p_removed": (0.0, 1e-8),
        "static_p_former": (0.0, 1e-8),
        "static_p_moved": (0.0, 0.0001),
        "static_p_moving": (0.0, 0.001),
        "static_p_appeared": 0.032,
        "static_p_stable": 0.243,
        "embodied_wins": 59,
        "embodied_losses": 22,
        "embodied_p_all": (0.0, 0.0001),
        "embodied_p_removed": 0.014,
        "embodied_p_former": 0.064,
        "embodied_interval_one": (0.228, 0.346),
        "embodied_interval_two": (0.388, 0.518),
        "embodied_interval_positions_two": (0.967, 0.997),
        "spl_given_success": 0.973,
        "gained_by_navigating": 12,
        "lost_by_navigating": 4,
        "rescued_stops": 12,
        "rescued_nearest_m": 1.0,
        "rescued_farthest_m": 2.6,
    },
    'Section "Where does the remaining difficulty lie"': {
        "rung_grounding": 0.064,
        "rung_mapping": 0.516,
        "rung_selection": 0.005,
        "answer_given": 1.0,
        "rung_navigation": 0.005,
        "handover_wins": 49,
        "handover_losses": 35,
        "handover_p": 0.16,
        "success_with_two": 0.366,
        "success_with_three": 0.514,
        "success_with_more": 0.458,
        "worst_scene": 0.1,
        "best_scene": 0.667,
        "worst_scene_grounding": 0.5,
    },
    'Fig. "difficulty"': {"episodes_with_two": 123, "episodes_with_three": 37, "episodes_with_more": 59},
    "Validity checks": {
        "parser_accuracy": 0.941,
        "success_supplied": 0.406,
        "success_inferred": 0.406,
        "two_seed_0": 0.452,
        "two_seed_1": 0.461,
        "two_seed_2": 0.461,
        "one_seed_0": 0.283,
        "one_seed_1": 0.256,
        "one_seed_2": 0.247,
        "embodied_margin_least": 0.169,
        "embodied_margin_greatest": 0.215,
        "admissibility_settings": 256,
        "static_margin_least": 0.224,
        "static_margin_greatest": 0.247,
        "cow_least": 0.119,
        "cow_greatest": 0.128,
        "cow_former_least": 0.026,
        "cow_former_greatest": 0.053,
        "dualmap_worst_pairing": -0.029,
        "dualmap_worst_pairing_former": -0.135,
    },
    'Section "Reference agent"': {"single_ray_worst_m": 25.5, "self_check_objects": 262, "self_check_scenes": 20},
    'Section "Results"': {"mapping_s_an_episode": 1.9, "static_gate_s": 5, "embodied_pass_min": 24, "cow_pass_min": (30, 34)},
    'Fig. "diag"': {"gate_span": 0.027, "gate_least_m": 0.75, "gate_greatest_m": 2.5},
    'Table "params"': {"gate_in_force_m": 1.25, "gate_delta_min_m": 1.5},
    "Multi-change diagnostic split": {
        "multi_success": 0.676,
        "multi_success_with_appearance": 0.671,
        "multi_best_auroc": 0.588,
        "multi_held_out_auroc": 0.5,
    },
    'Section "Do the existing paradigms fail"': {
        "cow_former_over_seeds": 0.035,
        "cow_any_instance": 0.333,
        "cow_wins": 83,
        "cow_losses": 11,
        "cow_p": (0.0, 1e-14),
        "dualmap_difference": 0.01,
        "dualmap_objects_degenerate": 7,
        "dualmap_objects_least": 43,
        "dualmap_objects_most": 89,
    },
}
"""Figures of the text by the place that they are printed at; a pair is a range, one from 0 a bound."""


PAPER: Mapping[str, Printed] = {
    f"{table}.{row}.{column}": Printed(f'Table "{table}"', value, value)
    for table, rows in TABLES.items()
    for row, cells in rows.items()
    for column, value in zip(COLUMNS, cells, strict=False)
} | {
    key: Printed(place, *value) if isinstance(value, tuple) else Printed(place, value, value)
    for place, entries in IN_TEXT.items()
    for key, value in entries.items()
}
"""All figures by key: "static.two.all" of a table, "parser_accuracy" of the text."""
