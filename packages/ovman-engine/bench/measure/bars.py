"""Figures and their bounds: the table at the end of every measurement."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass


@dataclass(frozen=True)
class Bar:
    """A figure and its bound: at most `bar`, or at least `bar` if `at_least`. `value` is None if it could not be measured."""

    name: str
    value: float | None
    bar: float
    unit: str
    at_least: bool = False

    @property
    def verdict(self) -> str:
        if self.value is None:
            return "not measured"
        return "pass" if (self.value >= self.bar if self.at_least else self.value <= self.bar) else "FAIL"


def show(bars: Iterable[Bar]) -> None:
    print(f"\n{'bar':56s}{'measured':>12s}{'bar':>12s}")
    for bar in bars:
        value = "" if bar.value is None else f"{bar.value:.2f} {bar.unit}"
        print(f"{bar.name:56s}{value:>12s}{'>=' if bar.at_least else '<=':>4s}{bar.bar:5g} {bar.unit:3s} {bar.verdict}")
