"""Which code a stage runs: a digest of its script and of every module of ovman that the script imports, however indirectly.

Comments, docstrings, layout and `__version__` do not count, so that prose costs no computing time; everything else does, so that
no result is older than the code that is said to have made it.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = "ovman"
BOUNDARY = frozenset({"ovman.config", "ovman.provenance", "ovman.sections", "ovman.stages"})
"""Not followed: they choose the parameter of a stage, which is compared itself. A new line in STAGES is no new code."""


def script(stage: str, root: Path = ROOT) -> Path:
    """Where the workflow has the script of a stage."""
    return root / "workflow" / "scripts" / f"{stage}.py"


@cache
def code_digest(stage: str, root: Path = ROOT) -> str:
    """Digest of the code that a stage runs, as the files were when it was first asked for."""
    return digest(script(stage, root), root)


def digest(entry: Path, root: Path = ROOT) -> str:
    """Hexadecimal digest of the file `entry` and of its transitive imports from the package under `root`."""
    parts = [_content(entry)] + [f"{name}:{_content(path)}" for name, path in sorted(modules(entry, root).items())]
    return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]


def modules(entry: Path, root: Path = ROOT) -> dict[str, Path]:
    """Every module of the package that `entry` imports, directly or not, by its dotted name."""
    found: dict[str, Path] = {}
    waiting = [name for imported in _imports(entry, "") for name in _resolved(imported, root)]
    while waiting:
        name = waiting.pop()
        if name in found or name in BOUNDARY:
            continue
        path = _file(name, root)
        if path is None:
            continue
        found[name] = path
        package = name if path.name == "__init__.py" else name.rpartition(".")[0]
        waiting += [n for imported in _imports(path, package) for n in _resolved(imported, root)]
        # A package that can be run is imported by those who start it as a process.
        if path.name == "__init__.py" and (path.parent / "__main__.py").exists():
            waiting.append(f"{name}.__main__")
    return found


def _resolved(name: str, root: Path) -> Iterator[str]:
    """`name` and the packages around it; `name` may be an attribute of a module, in which case there is no file for it."""
    parts = name.split(".")
    if parts[0] == PACKAGE:
        yield from (".".join(parts[:k]) for k in range(1, len(parts) + 1) if _file(".".join(parts[:k]), root) is not None)


def _file(name: str, root: Path) -> Path | None:
    base = root.joinpath(*name.split("."))
    for path in (base / "__init__.py", base.with_suffix(".py")):
        if path.is_file():
            return path
    return None


def _imports(path: Path, package: str) -> tuple[str, ...]:
    return tuple(_absolute(name, level, package) for name, level in _read(path)[1])


def _absolute(name: str, level: int, package: str) -> str:
    if level == 0:
        return name
    base = package.split(".")
    return ".".join(base[: len(base) - level + 1] + ([name] if name else []))


def _content(path: Path) -> str:
    return _read(path)[0]


def _read(path: Path) -> tuple[str, tuple[tuple[str, int], ...]]:
    """Digest of a module without its prose, and what it imports as (name, level of a relative import)."""
    return _parsed(path.read_bytes())


@cache
def _parsed(source: bytes) -> tuple[str, tuple[tuple[str, int], ...]]:
    tree = ast.parse(source)
    imports: list[tuple[str, int]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            imports += [(alias.name, 0) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            imports.append((module, node.level))
            imports += [(f"{module}.{alias.name}".lstrip("."), node.level) for alias in node.names]
        elif isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [statement for statement in node.body if not _prose(statement)]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(imports)


def _prose(statement: ast.stmt) -> bool:
    """A docstring (of a module, class, function or attribute), or the number of the version."""
    if isinstance(statement, ast.Expr):
        return isinstance(statement.value, ast.Constant) and isinstance(statement.value.value, str)
    return isinstance(statement, ast.Assign) and [getattr(t, "id", None) for t in statement.targets] == ["__version__"]
