"""The modules of the engine import no other package of the project, and never each other in a circle."""

from __future__ import annotations

import ast
import sys
import tomllib
from graphlib import TopologicalSorter
from importlib.metadata import packages_distributions
from pathlib import Path

import ovman_engine

ROOT = Path(ovman_engine.__file__).parents[1]
PATHS = {
    ".".join(p.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): p for p in ROOT.glob("ovman_engine/**/*.py")
}


def imported(path: Path) -> set[str]:
    """Names of all modules that a file imports: at its top, inside functions, and for types alone."""
    found = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            names = {f"{node.module}.{alias.name}" for alias in node.names}
            found |= {name if name in PATHS else node.module for name in names}
    return found


def test_no_circles() -> None:
    graph = {name: imported(path) & PATHS.keys() - {name} for name, path in PATHS.items()}
    assert len(list(TopologicalSorter(graph).static_order())) == len(PATHS) > 100


def test_only_declared_packages_are_imported() -> None:
    imports = {name.partition(".")[0] for path in PATHS.values() for name in imported(path)}
    outside = imports - sys.stdlib_module_names - {"ovman_engine"}
    declared = tomllib.loads((Path(__file__).parents[1] / "pyproject.toml").read_text())["project"]["dependencies"]
    distributions = packages_distributions()
    for module in outside:
        assert any(line.startswith(name.lower()) for name in distributions[module] for line in declared), module
