"""The solver that is loaded alone is SciPy's."""

from __future__ import annotations

import subprocess
import sys
from importlib.util import find_spec

import numpy as np
import pytest
from scipy.optimize import linear_sum_assignment

from ovman.agents.reference import assignment


def alone(monkeypatch: pytest.MonkeyPatch) -> object:
    """The compiled module, loaded as in a process without scipy.optimize."""
    monkeypatch.delitem(sys.modules, assignment.PACKAGE)
    module = assignment._alone()
    assert module is not None, "SciPy has its solver elsewhere: jobs import the whole package again"
    return module


def test_ties_and_rectangles_are_solved_as_scipy_does(monkeypatch: pytest.MonkeyPatch) -> None:
    module = alone(monkeypatch)
    rng = np.random.default_rng(0)
    for _ in range(300):
        shape = rng.integers(1, 9, 2)
        for cost in (rng.random(shape), rng.integers(0, 3, shape).astype(float)):
            found, expected = module.linear_sum_assignment(cost), linear_sum_assignment(cost)  # type: ignore[attr-defined]
            assert all(np.array_equal(a, b) for a, b in zip(found, expected, strict=True))


def test_the_package_is_not_loaded() -> None:
    code = (
        "import sys, numpy as np; from ovman.agents.reference.assignment import assigned;"
        "assert assigned(np.array([[2.0, 1.0], [1.0, 5.0]]))[1].tolist() == [1, 0]; print('scipy.optimize' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout == "False\n"


def test_the_package_is_used_where_it_is_loaded_anyway() -> None:
    assert assignment.PACKAGE in sys.modules and assignment._alone() is None
    assert assignment._solver.__wrapped__() is linear_sum_assignment


def test_a_module_without_the_solver_is_passed_over(monkeypatch: pytest.MonkeyPatch) -> None:
    """Another compiled module of the package stands for one of a SciPy that has its solver elsewhere."""
    assert find_spec("scipy.optimize._zeros") is not None
    monkeypatch.delitem(sys.modules, assignment.PACKAGE)
    monkeypatch.setattr(assignment, "SOLVER", "scipy.optimize._zeros")
    assert assignment._alone() is None


def test_a_scipy_without_the_module_is_used_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(sys.modules, assignment.PACKAGE)
    monkeypatch.setattr(assignment, "SOLVER", "scipy.optimize.no_such_module")
    assert assignment._alone() is None
    assert assignment._solver.__wrapped__() is not None
