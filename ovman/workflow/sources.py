"""What a source file says without its prose: a digest of it, what it imports, and which names it has."""

from __future__ import annotations

import ast
import hashlib
import json
import sys
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

from ovman.atomic import replace_bytes

Parsed = tuple[str, tuple[tuple[str, int], ...]]
"""Digest of a module without its prose, and what it imports as (name, level of a relative import)."""


class Memory:
    """Digests and imports of source files, by the SHA-256 of their content.

    Parsing all files takes longer than the rest of a job's start, so one process hands its findings to the next in a file.
    """

    def __init__(self) -> None:
        self._found: dict[str, Parsed] = {}
        self._handed: dict[str, Any] = {}
        self._path: Path | None = None

    def keep(self, path: Path) -> None:
        """Read what other processes found from the file `path`, and write there what this one finds. It may be deleted."""
        self._path = path
        with suppress(OSError, ValueError, AttributeError):  # not there, or cut off
            self._handed = json.loads(path.read_bytes()).get(_reader(), {})

    def parsed(self, source: bytes) -> Parsed:
        """What a source says. SyntaxError for one that is no Python."""
        key = hashlib.sha256(source).hexdigest()
        if key not in self._found:
            if key in self._handed:
                digest, imports = self._handed[key]
                self._found[key] = digest, tuple((name, level) for name, level in imports)
            else:
                self._found[key] = _parsed(source)
        return self._found[key]

    def save(self) -> None:
        """Write what this process has needed, if there was anything new in it."""
        if self._path is None or self._found.keys() <= self._handed.keys():
            return
        self._handed = dict(self._found)
        with suppress(OSError):
            replace_bytes(self._path, json.dumps({_reader(): self._found}).encode())


@cache
def _reader() -> str:
    """Version of the reader: another Python, or another version of this module, may find something else."""
    return hashlib.sha256(sys.version.encode() + Path(__file__).read_bytes()).hexdigest()


def _parsed(source: bytes) -> Parsed:
    tree = ast.parse(source)
    imports = tuple(imported(tree))
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef):
            node.body = [statement for statement in node.body if not _prose(statement)]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), imports


def imported(tree: ast.AST) -> Iterator[tuple[str, int]]:
    """What a source imports, by name and level, 0 for an absolute name. For an attribute of a module there is no such module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, 0) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            module = node.module or ""
            yield module, node.level
            yield from ((f"{module}.{alias.name}".lstrip("."), node.level) for alias in node.names)


def _prose(statement: ast.stmt) -> bool:
    """A docstring (of a module, class, function or attribute), or the number of the version."""
    if isinstance(statement, ast.Expr):
        return isinstance(statement.value, ast.Constant) and isinstance(statement.value.value, str)
    return isinstance(statement, ast.Assign) and [getattr(t, "id", None) for t in statement.targets] == ["__version__"]


def defined(source: bytes) -> set[str] | None:
    """The names that a module has at its top, as far as its source says; None for one that imports all of another."""
    names: set[str] = set()
    for node in ast.parse(source).body:
        match node:
            case ast.FunctionDef(name=name) | ast.AsyncFunctionDef(name=name) | ast.ClassDef(name=name):
                names.add(name)
            case ast.Import(names=aliases) | ast.ImportFrom(names=aliases):
                names |= {(alias.asname or alias.name).split(".")[0] for alias in aliases}
            case ast.Assign(targets=targets):
                names |= {node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name)}
            case ast.AnnAssign(target=ast.Name(id=name)):
                names.add(name)
            case ast.If() | ast.Try():
                return None
    return None if "*" in names else names
