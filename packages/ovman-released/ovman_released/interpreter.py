"""The Python interpreter of a released system's own environment: is it there, and has it what the system needs?

The interpreter is asked by a program of its own, which imports nothing of this package: it need not be able to.
"""

from __future__ import annotations

import json
import os
import shlex
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType

from ovman.records.record import Record

OLDEST = (3, 11)
"""This package's oldest Python; the runners import its simulator session."""
TIMEOUT_S = 300.0
"""PyTorch alone is imported for half a minute from a cold disk."""
_OF_THIS_PYTHON = ("PYTHONPATH", "PYTHONHOME", "PYTHONNOUSERSITE", "PYTHONSAFEPATH", "VIRTUAL_ENV", "CONDA_PREFIX")

_PROGRAM = """
import importlib, importlib.metadata, importlib.util, json, sys
asked = json.loads(sys.argv[1])
found = {"version": list(sys.version_info[:2]), "modules": {}, "broken": {}, "cuda": None, "cached": {}}
for name in asked["modules"]:
    try:
        found["modules"][name] = importlib.util.find_spec(name) is not None
    except (ImportError, ValueError):
        found["modules"][name] = False
found["versions"] = {}
for name in asked["versions"]:
    try:
        found["versions"][name] = importlib.metadata.version(name)
    except importlib.metadata.PackageNotFoundError:
        found["versions"][name] = None
for name in asked["imported"]:
    if found["modules"][name]:
        try:
            importlib.import_module(name)
        except Exception as error:
            found["broken"][name] = " ".join(f"{type(error).__name__}: {error}".split())
if asked["cuda"] and found["modules"].get("torch"):
    import torch
    found["cuda"] = bool(torch.cuda.is_available())
for repository, alternatives in asked["cached"].items():
    try:
        from huggingface_hub import try_to_load_from_cache as kept
        there = all(any(isinstance(kept(repository, name), str) for name in names) for names in alternatives)
    except ImportError:
        there = False
    found["cached"][repository] = there
print("OVMAN " + json.dumps(found))
"""


class _Found(Record):
    """What the program answers: Python's version, which modules are there, what importing those raises that cannot be imported,
    versions of packages, whether torch sees a GPU (None where it was not asked), and which repositories of Hugging Face are
    downloaded."""

    version: tuple[int, int]
    modules: Mapping[str, bool]
    broken: Mapping[str, str]
    versions: Mapping[str, str | None]
    cuda: bool | None
    cached: Mapping[str, bool]


@dataclass(frozen=True)
class Needs:
    """What a system needs of its environment.

    modules: by the name that is imported, the package to install. versions: packages that must be of one version. cached: for a
    repository of Hugging Face, groups of files of which one each must have been downloaded; the command that downloads them.
    oldest: Python that the system's process runs with. imported: of the modules, those that may be there and not work, with the
    remedy.
    """

    modules: Mapping[str, str]
    versions: Mapping[str, str]
    cached: Mapping[str, tuple[Sequence[Sequence[str]], str]]
    oldest: tuple[int, int] = OLDEST
    imported: Mapping[str, str] = field(default_factory=dict)


def lacks(key: str, python: str, device: str, needs: Needs, environment: Mapping[str, str] | None = None) -> str | None:
    """What is missing and how to get it, in one line; None where everything is there.

    key: section of the settings that names the interpreter, e.g. "released_cow"; device: "cuda" where a GPU is needed;
    environment: instead of this process's.
    """
    if not python:
        return f"{key}.python names no interpreter; give that of its own environment"
    asked = {
        "modules": list(needs.modules),
        "imported": list(needs.imported),
        "versions": list(needs.versions),
        "cuda": device == "cuda",
        "cached": {repository: [list(names) for names in files] for repository, (files, _) in needs.cached.items()},
    }
    command = [python, "-c", _PROGRAM, json.dumps(asked)]
    env = dict(os.environ if environment is None else environment)
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=TIMEOUT_S, stdin=subprocess.DEVNULL, env=env)
    except (FileNotFoundError, PermissionError, NotADirectoryError) as error:
        return f"{key}.python is {python}: {error.strerror}; give the path of a Python interpreter"
    except OSError as error:
        return f"{key}.python is {python}, which does not start ({error.strerror}); give the path of a Python interpreter"
    except subprocess.TimeoutExpired:
        return f"{key}.python is {python}, which does not answer within {TIMEOUT_S:.0f} s"
    answers = [line for line in done.stdout.splitlines() if line.startswith("OVMAN ")]
    if not answers:
        said = (done.stderr.strip().splitlines() or [f"exit status {done.returncode}"])[-1]
        return f"{key}.python is {python}, which is no working Python interpreter ({said}); give the path of one"
    return _first(key, python, device, needs, _Found.parse(answers[-1].removeprefix("OVMAN "), python))


def _first(key: str, python: str, device: str, needs: Needs, found: _Found) -> str | None:
    if found.version < needs.oldest:
        wanted, has = ".".join(map(str, needs.oldest)), ".".join(map(str, found.version))
        return f"{key}.python is Python {has}; the wrapper needs {wanted} or newer"
    pip = f"{shlex.quote(python)} -m pip install"
    absent = [package for module, package in needs.modules.items() if not found.modules[module]]
    if absent:
        return f"its environment lacks {', '.join(absent)}; run: {pip} {' '.join(absent)}"
    for module, said in found.broken.items():
        return f"{module} of its environment cannot be imported ({said}); {needs.imported[module]}"
    for package, wanted in needs.versions.items():
        if found.versions[package] != wanted:
            return f"its environment has {package} {found.versions[package]}; run: {pip} {package}=={wanted}"
    for repository, (_, command) in needs.cached.items():
        if not found.cached[repository]:
            return f"the weights {repository} are not downloaded; run: {shlex.quote(python)} {command}"
    if device == "cuda" and not found.cuda:
        return f'its PyTorch sees no GPU; give this job one, or set {key}.device to "cpu"'
    return None


def environment(*paths: Path) -> dict[str, str]:
    """Environment variables for a process of a released system.

    paths: folders that its Python finds modules in, beside its own environment. Nothing of this process's Python environment is
    handed on, nothing is downloaded, and no bytecode is written into the clone. What the process prints is in its log at once,
    and a crash of native code leaves a stack there: the process may end at any time.
    """
    kept = {name: value for name, value in os.environ.items() if name not in _OF_THIS_PYTHON}
    if paths:
        kept["PYTHONPATH"] = os.pathsep.join(map(str, paths))
    python = {"PYTHONDONTWRITEBYTECODE": "1", "PYTHONUNBUFFERED": "1", "PYTHONFAULTHANDLER": "1"}
    return kept | python | {"HF_HUB_OFFLINE": "1", "TRANSFORMERS_OFFLINE": "1"}


def linked(directory: Path, *packages: ModuleType) -> Path:
    """`directory`, made with a link to each of these packages: what else lies beside them here is not to be found there."""
    directory.mkdir(parents=True)
    for package in packages:
        (directory / package.__name__).symlink_to(Path(package.__path__[0]).resolve(), target_is_directory=True)
    return directory
