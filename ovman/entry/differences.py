"""What differs between a run as it was recorded and as it was driven again, and how much may differ between processors. Pure.

The last bits of floating-point arithmetic depend on the processor: libraries choose the instructions that it has, and some add
and multiply in one step. A move is blocked or it is not, so a run goes the same way or another one altogether: how it ends, what
was done and the verdict must be equal. What was measured may differ by what rounding can do. Records hold 0.1 mm, 0.01 degrees
and whole pixels; a number between two of these steps may be rounded to either.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from ovman.records.run import Score

METRES = 0.001
"""Ten steps of what a record holds; a thousandth of the success radius."""
DEGREES = 0.1
"""Ten steps of what a record holds."""
PIXELS = 5
"""Of a mask: pixels on its rim, whose rays pass an edge within rounding; a twentieth of the least mask that is in sight."""
SPL = 0.001
"""SPL is a quotient of lengths, of which the shorter is of the episode's record."""
TOLERANCES: Mapping[str, float] = {"metres": METRES, "degrees": DEGREES, "pixels": PIXELS, "SPL": SPL}

MISSING = "nothing"
"""Stands for the value of a key that is not there."""


@dataclass(slots=True)
class Compared:
    """Two runs beside each other.

    differences: (key, recorded, driven) of what must be equal and is not, or differs by more than its tolerance. deviations: the
    greatest deviation within its tolerance, by unit, above 0.
    """

    differences: list[tuple[str, Any, Any]] = field(default_factory=list)
    deviations: dict[str, float] = field(default_factory=dict)


def compared(recorded: Score, driven: Score) -> Compared:
    """A run as it was recorded beside the same run driven again, by the keys of their records."""
    found = Compared()
    there, here = dict(flat(recorded.to_json())), dict(flat(driven.to_json()))
    for key in dict.fromkeys([*there, *here]):
        one, other = there.get(key, MISSING), here.get(key, MISSING)
        if one == other:
            continue
        unit = unit_of(key)
        apart = _apart(unit, one, other)
        if unit is None or apart is None or round(apart, 6) > TOLERANCES[unit]:
            found.differences.append((key, one, other))
        else:
            found.deviations[unit] = max(found.deviations.get(unit, 0.0), round(apart, 6))
    return found


def unit_of(key: str) -> str | None:
    """The unit of the number under a key such as "visible_px.30", None for what must be equal."""
    *above, last = key.split(".")
    if "visible_px" in above:
        return "pixels"
    if last.endswith("_m") or "path_at_m" in above or (above == ["stop"] and last in ("x", "z")):
        return "metres"
    if last.endswith("_deg"):
        return "degrees"
    return "SPL" if last == "spl" else None


def flat(value: Any, key: str = "") -> Iterator[tuple[str, Any]]:
    """The values of a JSON object by the paths of their keys, joined by dots; an empty object or list is a value."""
    if isinstance(value, Mapping) and value:
        for name, inner in value.items():
            yield from flat(inner, f"{key}.{name}" if key else str(name))
    elif isinstance(value, list) and value:
        for number, inner in enumerate(value):
            yield from flat(inner, f"{key}[{number}]")
    else:
        yield key, value


def _apart(unit: str | None, one: Any, other: Any) -> float | None:
    """How far two numbers are apart, None where one of them is no number."""
    numbers = [value for value in (one, other) if isinstance(value, int | float) and not isinstance(value, bool)]
    if len(numbers) < 2:
        return None
    apart = abs(numbers[0] - numbers[1])
    return min(apart % 360.0, -apart % 360.0) if unit == "degrees" else apart
