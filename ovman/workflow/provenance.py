"""Which code a stage runs: a digest of its script and of every module of ovman that the script imports, however indirectly.

Comments, docstrings, layout and `__version__` do not count, so that prose costs no computing time; everything else does, so that
no result is older than the code that is said to have made it.
"""

from __future__ import annotations

import hashlib
import json
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from ovman.shipped import HOME
from ovman.workflow.sources import Memory, Parsed, defined

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = {"ovman": ".", "ovman_engine": "packages/ovman-engine"}
"""The packages of this repository, and where each lies under its root. Where wheels are installed they lie side by side."""
EQUAL_CODE = Path("workflow", "equal_code.json")
"""Digests of this checkout's code to those of the release's code with the same results."""
BOUNDARY = frozenset(
    {
        "ovman.settings.config",
        "ovman.settings.plugins",
        "ovman.workflow.provenance",
        "ovman.settings",
        "ovman.workflow.stages",
    }
)
"""Excluded: these modules only build the parameter, which Snakemake compares directly. A new line in STAGES is no new code."""


def script(stage: str, root: Path = ROOT) -> Path:
    """Where the workflow has the script of a stage."""
    return (HOME if root == ROOT else root) / "workflow" / "scripts" / f"{stage}.py"


@cache
def code_digest(stage: str, root: Path = ROOT) -> str:
    """Digest of the code that a stage runs, as the files were when any stage's was first asked for."""
    return released_digest(_sources(root).digest(script(stage, root)))


@cache
def script_digest(path: Path, plugin: str, root: Path = ROOT) -> str:
    """Digest of a script of a plug-in, of what it imports from the plug-in's package, and from ovman.

    plugin: the plug-in's module by its dotted name; like BOUNDARY, it is not followed.
    """
    return released_digest(_sources(root).script_digest(path, plugin))


@cache
def module_digest(name: str, root: Path = ROOT) -> str | None:
    """Digest of a module by its dotted name and of what it imports from its own package and from ovman; None if it is not there.

    Nothing is imported: the file is looked for where Python would look.
    """
    found = _sources(root).module_digest(name)
    return None if found is None else released_digest(found)


def released_digest(found: str) -> str:
    """Return the digest of the release's code that `found` is equal to in its results; `found` itself if there is none.

    workflow/equal_code.json has the pairs. `python -m ovman.workflow.differences` writes it, after the results were compared.
    """
    return _equal_code().get(found, found)


@cache
def _equal_code() -> dict[str, str]:
    path = HOME / EQUAL_CODE
    pairs: dict[str, str] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return pairs


def module_file(name: str, root: Path = ROOT) -> Path | None:
    """Where the source of a module lies, by its dotted name; None if it is not there. Nothing is imported."""
    return _sources(root).module_file(name)


def lacking(module: str, function: str, place: str = "beside the overlay") -> str | None:
    """What is wrong with an agent, and the remedy; None where it is there. place: where its module may lie."""
    path = module_file(module)
    if path is None:
        return f"there is no module {module}; install it, or put it {place}"
    try:
        names = defined(path.read_bytes())
    except SyntaxError as error:
        return f"{path.name}, line {error.lineno}, is not Python: {error.msg}; mend it"
    if names is not None and function not in names:
        there = ", ".join(sorted(name for name in names if not name.startswith("_")))
        return f"{module} has no function {function}; " + (f"name one that it has: {there}" if there else "write it")
    return None


def digest(entry: Path, root: Path = ROOT) -> str:
    """Hexadecimal digest of the file `entry` and of its transitive imports from the package under `root`."""
    return _Sources(root).digest(entry)


def modules(entry: Path, root: Path = ROOT) -> dict[str, Path]:
    """Every module of the package that `entry` imports, directly or not, by its dotted name."""
    return _Sources(root).modules(entry)


class _Sources:
    """The package under a root; each of its files is looked for and read once."""

    def __init__(self, root: Path) -> None:
        self._root = root
        self._packages, self._boundary = set(PACKAGES), set(BOUNDARY)
        self._places: dict[str, Path | None] = {}
        self._read: dict[Path, Parsed] = {}
        self._imported: dict[tuple[Path, str, frozenset[str]], tuple[str, ...]] = {}

    def digest(self, entry: Path) -> str:
        return self._digest([self._parsed(entry)[0]], self.modules(entry))

    def script_digest(self, path: Path, plugin: str) -> str:
        packages, boundary = self._packages, self._boundary
        self._packages, self._boundary = packages | {plugin.split(".")[0]}, boundary | {plugin}
        try:
            return self.digest(path)
        finally:
            self._packages, self._boundary = packages, boundary

    def module_digest(self, name: str) -> str | None:
        packages, self._packages = self._packages, self._packages | {name.split(".")[0]}
        try:
            found = self._reached([*_with_parents(name)])
            return self._digest([name], found) if name in found else None
        finally:
            self._packages = packages

    def module_file(self, name: str) -> Path | None:
        return self._place(name)

    def modules(self, entry: Path) -> dict[str, Path]:
        return self._reached([*self._imports(entry, "")])

    def _digest(self, parts: list[str], found: dict[str, Path]) -> str:
        parts = parts + [f"{name}:{self._parsed(path)[0]}" for name, path in sorted(found.items())]
        _memory.save()
        return hashlib.sha256("\n".join(parts).encode()).hexdigest()[:16]

    def _reached(self, waiting: list[str]) -> dict[str, Path]:
        found: dict[str, Path] = {}
        while waiting:
            name = waiting.pop()
            if name in found or not self._boundary.isdisjoint(_with_parents(name)):
                continue
            path = self._place(name)
            if path is None:
                continue
            found[name] = path
            package = name if path.name == "__init__.py" else name.rpartition(".")[0]
            waiting += [one for one in self._imports(path, package) if one not in found]
            # A package with __main__ is also started as a process by modules that import it.
            if path.name == "__init__.py":
                waiting.append(f"{name}.__main__")
        return found

    def _imports(self, path: Path, package: str) -> tuple[str, ...]:
        """What a file imports of the package, and the packages around that. For an attribute there is no file."""
        key = path, package, frozenset(self._packages)
        if key not in self._imported:
            names = {_absolute(name, level, package) for name, level in self._parsed(path)[1]}
            parts = (part for name in names if name.split(".")[0] in self._packages for part in _with_parents(name))
            self._imported[key] = tuple(dict.fromkeys(parts))
        return self._imported[key]

    def _place(self, name: str) -> Path | None:
        if name not in self._places:
            top, *_ = name.split(".")
            ours = self._root / PACKAGES[top] / top if top in PACKAGES else None
            bases = [ours] if ours is not None and (ours.is_dir() or self._root != ROOT) else _elsewhere(top)
            inside = [base.joinpath(*name.split(".")[1:]) for base in bases]
            places = (place for base in inside for place in (base / "__init__.py", base.with_suffix(".py")))
            self._places[name] = next((path for path in places if path.is_file()), None)
        return self._places[name]

    def _parsed(self, path: Path) -> Parsed:
        if path not in self._read:
            try:
                self._read[path] = _memory.parsed(path.read_bytes())
            except SyntaxError as error:
                error.filename = str(path)
                raise
        return self._read[path]


@cache
def _with_parents(name: str) -> tuple[str, ...]:
    """a.b.c is a, a.b and a.b.c."""
    parts = name.split(".")
    return tuple(".".join(parts[:k]) for k in range(1, len(parts) + 1))


def _elsewhere(top: str) -> list[Path]:
    """Where a top-level package or module outside this repository lies, without its suffix."""
    with suppress(ImportError, ValueError):
        spec = find_spec(top)
        if spec is not None and spec.submodule_search_locations is not None:
            return [Path(place) for place in spec.submodule_search_locations]
        if spec is not None and spec.origin is not None and spec.origin.endswith(".py"):
            return [Path(spec.origin).with_suffix("")]
    return []


@cache
def _sources(root: Path) -> _Sources:
    return _Sources(root)


_memory = Memory()


def remember(path: Path) -> None:
    """Share the findings about source files with other processes through the file `path`, which may be deleted."""
    _memory.keep(path)


def _absolute(name: str, level: int, package: str) -> str:
    if level == 0:
        return name
    base = package.split(".")
    return ".".join(base[: len(base) - level + 1] + ([name] if name else []))
