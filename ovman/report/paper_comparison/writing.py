"""Figures as text, one way for each kind, ours and the paper's alike."""

from __future__ import annotations

from ovman.report.paper_comparison.paper import Figure
from ovman.report.paper_comparison.statement import Form

EMPTY = "—"
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
SMALLEST_P = 1e-300
"""Below this a p value is written as a bound: it may have been rounded to zero."""


def written(value: float, form: Form) -> str:
    """Rates with three decimals, differences with their sign, small p values as powers of ten, metres with their unit."""
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
            return p_value(value)


def p_value(p: float) -> str:
    """0.032, 0.00043 as 4.3 × 10⁻⁴, and 0 as a bound."""
    if p < SMALLEST_P:
        return f"< {_power(SMALLEST_P)}"
    return f"{p:.3f}" if p >= 0.001 else _power(p)


def papers(figure: Figure, form: Form) -> str:
    """A figure of the paper, in the form of ours beside it."""
    if figure.below is not None:
        return f"< {_power(figure.below)}"
    if figure.low is not None and figure.high is not None:
        return f"{written(figure.low, form)} – {written(figure.high, form)}"
    assert figure.value is not None
    return written(figure.value, form)


def _power(p: float) -> str:
    mantissa, exponent = f"{p:.1e}".replace(".0e", "e").split("e")
    power = f"10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    return power if mantissa == "1" else f"{mantissa} × {power}"
