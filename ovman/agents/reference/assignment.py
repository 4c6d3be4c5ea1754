"""SciPy's solver of the assignment problem, without the package around it, whose import takes 0.4 s of every short job."""

from __future__ import annotations

import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from importlib.machinery import EXTENSION_SUFFIXES, ExtensionFileLoader, FileFinder
from importlib.util import find_spec, module_from_spec
from typing import Any

import numpy as np

PACKAGE, SOLVER = "scipy.optimize", "scipy.optimize._lsap"

Solve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def assigned(cost: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows (K,) and columns (K,) of the cheapest assignment of a cost matrix (N, M) with K = min(N, M), rows ascending.

    The very function `scipy.optimize.linear_sum_assignment`, so of equal optima the same one. ValueError for a cost that is NaN.
    """
    return _solver()(cost)


@cache
def _solver() -> Solve:
    """The compiled module alone; the package where it is loaded anyway, or where a SciPy has the module elsewhere."""
    solve: Solve = (_alone() or import_module(PACKAGE)).linear_sum_assignment
    return solve


def _alone() -> Any:
    package = None if PACKAGE in sys.modules else find_spec(PACKAGE)
    for folder in (package and package.submodule_search_locations) or ():
        spec = FileFinder(folder, (ExtensionFileLoader, EXTENSION_SUFFIXES)).find_spec(SOLVER)
        if spec is not None and spec.loader is not None:
            module = module_from_spec(spec)
            spec.loader.exec_module(module)
            return module if hasattr(module, "linear_sum_assignment") else None
    return None
