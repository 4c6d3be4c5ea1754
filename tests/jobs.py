"""Jobs without Snakemake. Imports nothing: processes of tests start with it."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any


class Named(dict):
    """Snakemake's named lists: iterating gives the values."""

    def __iter__(self) -> Any:
        return iter(self.values())


def rule(constants: str, **parts: Any) -> SimpleNamespace:
    """What Snakemake gives to a script. constants: the parameter of the rule."""
    empty = {"input": Named(), "output": Named(), "wildcards": Named(scene="FloorPlan1"), "log": "", "resources": {}}
    return SimpleNamespace(rule="scenes", params=SimpleNamespace(constants=constants), **(empty | parts))
