"""Digests of the code that a rule runs: a change of the code reruns what it made and makes its cached work items unused.

Comments, docstrings, assertions and layout do not count; compiled kernels count with all their bytes. A module counts with every
module of OVMAN that it imports, directly or not, and with a JSON or YAML file that is named like the module, such as weights.
"""

from __future__ import annotations

import ast
import hashlib
from functools import cache
from importlib.machinery import PathFinder
from importlib.util import find_spec
from pathlib import Path
from types import CodeType

import grimp

PACKAGES = ("ovman", "ovman_engine")
ENGINE = "ovman_engine.__main__"


def digest_code(*modules: str) -> str:
    """Return 16 hexadecimal digits of modules, by dotted name, and of what they import; of all code of OVMAN for no modules.

    A module outside OVMAN, such as an entrant's agent, counts with the files of its own package.

    Raises:
        ModuleNotFoundError: One of the modules does not exist.
        SyntaxError: One of the files is not Python.
    """
    found: set[Path] = set()
    for module in modules or _graph().modules:
        if module.partition(".")[0] in PACKAGES:
            found |= _closure(module)
        else:
            outside = _files_outside(module)
            found |= outside.union(*(_closure(name) for path in outside for name in _imports(path)))
    return hashlib.sha256("".join(sorted(map(_digest_file, found))).encode()).hexdigest()[:16]


@cache
def _graph() -> grimp.ImportGraph:
    graph = grimp.build_graph(*PACKAGES, cache_dir=None, exclude_type_checking_imports=True)
    # The name of a home has the digest of its house: jobs that load homes by name need not run again when the generator changes.
    graph.remove_import(importer="ovman.sim.scenes", imported="ovman.homes.generate")
    return graph


@cache
def _closure(module: str) -> set[Path]:
    """Return the files of a module of OVMAN and of all that it imports."""
    if module not in _graph().modules:
        raise ModuleNotFoundError(f"there is no module {module}", name=module)
    names = {module} | _graph().find_upstream_modules(module)
    files = {_file(name) for name in names}
    files |= {data for path in files for suffix in (".json", ".yaml") if (data := path.with_suffix(suffix)).is_file()}
    if module == ENGINE:
        return files | set(_file("ovman_engine").parent.glob("kernels.*.so"))
    return files | _closure(ENGINE) if "ovman_engine" in names else files  # the simulator is a process of its own


@cache
def _file(module: str) -> Path:
    spec = find_spec(module.partition(".")[0])
    assert spec is not None and spec.origin is not None  # grimp has found it
    place = Path(spec.origin).parent.joinpath(*module.split(".")[1:])
    package = place / "__init__.py"  # a folder without it may be left of a package that is now a module
    return package if package.is_file() else place.with_suffix(".py")


def _files_outside(module: str) -> set[Path]:
    name = module.partition(".")[0]
    spec = PathFinder.find_spec(name, [str(Path.cwd())]) or find_spec(name)  # nothing of the working directory is imported
    if spec is None or spec.origin is None:
        raise ModuleNotFoundError(f"there is no module {module}", name=module)
    path = Path(spec.origin)
    return set(path.parent.rglob("*.py")) if path.name == "__init__.py" else {path}


def _imports(path: Path) -> set[str]:
    """Return the modules of OVMAN that a file imports."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_bytes(), str(path))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return names & _graph().modules


@cache
def _digest_file(path: Path) -> str:
    if path.suffix != ".py":
        return hashlib.sha256(path.read_bytes()).hexdigest()
    code = compile(path.read_bytes(), str(path), "exec", dont_inherit=True, optimize=2)  # without docstrings and assertions
    return hashlib.sha256(repr(_strip(code)).encode()).hexdigest()


def _strip(constant: object) -> object:
    """Replace code by its parts without line numbers, and sets by sorted lists, in a constant of compiled code."""
    match constant:
        case CodeType():
            arguments = constant.co_argcount, constant.co_posonlyargcount, constant.co_kwonlyargcount, constant.co_flags
            names = constant.co_names, constant.co_varnames, constant.co_freevars, constant.co_cellvars
            body = constant.co_code, constant.co_exceptiontable, _strip(constant.co_consts)
            return arguments, names, body
        case tuple():
            return tuple(map(_strip, constant))
        case frozenset():
            return sorted(map(repr, constant))
    return constant
