"""Surface forms that the parser was written with: what people say when they send a robot to a thing that changed."""

from __future__ import annotations

from collections.abc import Mapping

from ovman.language import sentence
from ovman.language.held_out import Form


def _both(text: str) -> Form:
    return Form(text, text)


# A thing that was moved is still in the home, one that was taken away is not. FORMER and REMOVED both ask for where the thing was
# in the first visit, and each form says which of the two it means.
FORMS: Mapping[str, tuple[Form, ...]] = {
    "moved": (
        Form("find the {noun} that has been moved", "find the {noun} that have been moved"),
        _both("please go to the {noun} that somebody moved"),
        Form("take me to the {noun} which was put somewhere else", "take me to the {noun} which were put somewhere else"),
        Form("could you show me the {noun} that changed its place?", "could you show me the {noun} that changed their place?"),
        _both("go to the relocated {noun}"),
    ),
    "former": (
        Form("go back to where the {noun} was before", "go back to where the {noun} were before"),
        _both("find the place where the {noun} used to stand"),
        _both("please drive to the former place of the {noun}"),
        _both("take me to the old spot of the {noun}"),
        Form("go to the place that the {noun} was moved from", "go to the place that the {noun} were moved from"),
    ),
    "moving": (
        Form("find the {noun} that is moving around", "find the {noun} that are moving around"),
        _both("please follow the moving {noun}"),
        Form("go to the {noun} that keeps moving", "go to the {noun} that keep moving"),
        Form("which {noun} is in motion?", "which {noun} are in motion?"),
        Form("catch the {noun} that is wandering about", "catch the {noun} that are wandering about"),
    ),
    "stable": (
        Form("find the {noun} that has not been moved", "find the {noun} that have not been moved"),
        _both("please go to the {noun} that did not move"),
        Form("go to the {noun} that is still where it was", "go to the {noun} that are still where they were"),
        _both("show me the {noun} that nobody moved"),
        Form("take me to the {noun} that remained in its place", "take me to the {noun} that remained in their place"),
    ),
    "appeared": (
        _both("go to the new {noun}"),
        Form("find the {noun} that has appeared", "find the {noun} that have appeared"),
        Form("please go to the {noun} that was added", "please go to the {noun} that were added"),
        _both("show me the {noun} that I have not seen before"),
        Form("take me to the {noun} that someone brought in", "take me to the {noun} that someone brought in"),
    ),
    "removed": (
        Form("please go to where the {noun} stood that is gone now", "please go to where the {noun} stood that are gone now"),
        _both("show me where the missing {noun} used to be"),
        Form("take me to where the {noun} was taken from", "take me to where the {noun} were taken from"),
        _both("go to the spot of the {noun} that disappeared"),
        Form("where was the {noun} that somebody took away?", "where were the {noun} that somebody took away?"),
    ),
}
"""Next to the canonical form of `ovman.language`, by the name of the relation."""


def sentences(relation: str, noun: str) -> tuple[str, ...]:
    """Every sentence of a query, the canonical one first."""
    return (sentence(relation, noun), *(form.fill(noun) for form in FORMS[relation]))
