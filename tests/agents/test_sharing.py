"""Results about tours are kept by the contents of the tours, and by nothing else that may differ."""

import numpy as np

from ovman.agents.interface import Visit
from ovman.agents.sharing import KEPT, keep_last


def visit(content):
    return Visit((), np.zeros((0, 2)), content)


def counted():
    """A function of a visit and a number that says how often it was called."""
    calls = []

    @keep_last
    def make(one, number):
        calls.append((one.content, number))
        return one.content, number

    return make, calls


def test_an_equal_tour_is_looked_at_once_and_another_tour_or_constant_anew():
    make, calls = counted()
    assert make(visit("a"), 1) is make(visit("a"), 1) and len(calls) == 1
    assert make(visit("a"), 2) == ("a", 2) and make(visit("b"), 1) == ("b", 1) and len(calls) == 3


def test_only_the_last_results_are_kept():
    make, calls = counted()
    for name in range(KEPT + 1):
        make(visit("first"), 0)
        make(visit(str(name)), 0)
    assert len(calls) == KEPT + 2, "the first visit of several pairs stays"
    make(visit("0"), 0)
    assert len(calls) == KEPT + 3


def test_nothing_is_kept_of_a_tour_of_unknown_content():
    make, calls = counted()
    make(visit(None), 1)
    make(visit(None), 1)
    assert len(calls) == 2
