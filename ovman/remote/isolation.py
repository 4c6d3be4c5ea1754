"""Choose how an agent's process is isolated, and make the command that starts it isolated."""

from __future__ import annotations

import json
import os
import platform
import shutil
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping, Sequence
from enum import StrEnum
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import yaml

from ovman.remote import confine
from ovman.settings.settings_files import read_merged, with_parts
from ovman.shipped import HOME, INSIDE

CONFINE = str(Path(confine.__file__).resolve())
ANSWERS = ("data", "leaderboard")
"""Folders of a wheel's shipped files that hold answers."""
PACKAGES = ("ovman", "ovman_client", "ovman_engine")
SYSTEM = (
    *("/usr", "/lib", "/lib32", "/lib64", "/bin", "/sbin", "/sys/devices/system/cpu"),
    *(
        f"/etc/{name}"
        for name in ("ld.so.cache", "ld.so.conf", "ld.so.conf.d", "alternatives", "fonts", "localtime", "os-release")
    ),
)
KERNEL = tuple(f"/proc/{name}" for name in ("cpuinfo", "meminfo", "stat", "version", "filesystems"))
"""Files that bubblewrap's /proc has of its own."""
DEVICES = ("/dev/null", "/dev/urandom", "/dev/random")
TMP_BYTES = str(1 << 28)
"""Size of bubblewrap's /tmp. TMPDIR names another folder."""
PROBE = ("--unshare-all", "--die-with-parent", "--ro-bind", "/", "/", "--proc", "/proc", "true")


class Isolation(StrEnum):
    """The means by which an agent's process is isolated, the strongest first."""

    BUBBLEWRAP = "bubblewrap"
    LANDLOCK = "landlock"
    NONE = "none"


@cache
def unavailable(level: Isolation) -> str | None:
    """Return why a level is not available on this machine, with the remedy; None if it is available."""
    if level is Isolation.NONE:
        return None
    if platform.machine() not in confine.ARCHITECTURES or sys.platform != "linux":
        return f"system calls cannot be filtered for {sys.platform} on {platform.machine()}; use Linux on x86-64 or arm64"
    if level is Isolation.LANDLOCK:
        abi = confine.landlock_abi()
        enough = f"it needs version {confine.LEAST_ABI}: use Linux 6.2 or later, or install bubblewrap"
        return None if abi >= confine.LEAST_ABI else f"the kernel has Landlock in version {max(abi, 0)}; {enough}"
    if (program := shutil.which("bwrap")) is None:
        return "bwrap is not installed; sudo apt install bubblewrap"
    probe = subprocess.run([program, *PROBE], capture_output=True, text=True)
    if probe.returncode == 0:
        return None
    return f"bwrap fails ({' '.join(probe.stderr.split())}); allow user namespaces, or use landlock"


def choose_isolation(wanted: str) -> Isolation:
    """Return the strongest level for "auto", else the level that is named. ValueError, in one line, if it is not available."""
    if wanted == "auto":
        return next(level for level in Isolation if unavailable(level) is None)
    if (why := unavailable(Isolation(wanted))) is not None:
        raise ValueError(f"--isolation {wanted}: {why}")
    return Isolation(wanted)


def describe(level: str | None) -> str:
    """Return a level in words: "isolated by landlock" or "not isolated"."""
    return "not isolated" if level in (None, Isolation.NONE) else f"isolated by {level}"


def explain(level: Isolation, error: str) -> str:
    """Return what to add to an error of an agent that the isolation may have caused, or an empty text."""
    refused = any(name in error for name in ("PermissionError", "FileNotFoundError", "ModuleNotFoundError", "BlockingIOError"))
    is_explained = refused and level is not Isolation.NONE
    return f"; the agent is {describe(level)}: docs/security.md says what it may read and do" if is_explained else ""


def make_command(
    level: Isolation, program: Sequence[str], folder: Path, memory: int, readable: Iterable[Path], hidden: Iterable[Path]
) -> list[str]:
    """Return the command that starts a program of Python isolated.

    Args:
        level: The isolation.
        program: Arguments of Python.
        folder: Has the folders that the program may write, work, home and tmp, and may be read.
        memory: Bytes.
        readable: Files and folders that it may read besides Python and OVMAN.
        hidden: Those that it may not read, wherever they lie.
    """
    answers = [place / name for place in _shipped() for name in ANSWERS]
    read, listed = _read_only([*_environment(), folder, *readable], [*hidden, *answers])
    write = [folder / name for name in ("work", "home", "tmp")]
    devices = [path for path in map(Path, DEVICES) if path.exists()]
    rules: dict[str, Any] = {"memory": memory, "calls": level is not Isolation.NONE, "files": None}
    if level is Isolation.LANDLOCK:
        paths = {"read": [*read, *map(Path, KERNEL)], "list": listed, "write": [*write, *devices]}
        rules["files"] = {name: [str(path) for path in some] for name, some in paths.items()}
    python = [sys.executable, "-I", "-S", CONFINE, json.dumps(rules), sys.executable, *program]
    if level is not Isolation.BUBBLEWRAP:
        return python
    binds = [("--ro-bind", path) for path in read]
    binds += [("--dev-bind", device) for device in devices] + [("--bind", path) for path in write]
    mounts = [str(word) for kind, path in binds for word in (kind, path, path)]
    tmp = ["--size", TMP_BYTES, "--tmpfs", "/tmp"]
    own = ["--proc", "/proc", *tmp, *mounts, "--remount-ro", "/", "--chdir", str(folder / "work")]
    return [str(shutil.which("bwrap")), "--unshare-all", "--die-with-parent", *own, *python]


def link_modules(module: str, folder: Path, also: Iterable[Path]) -> list[Path]:
    """Link the Python modules and packages of the working directory into a folder, and return their places.

    The links are the agent's path: what else lies in the working directory, such as earlier evaluations, is not in sight. Of a
    checkout of OVMAN only the agent's own module is linked. also: Other files that are linked if they lie there.
    """
    folder.mkdir()
    here, own = Path.cwd(), module.partition(".")[0]
    found = {here / f"{own}.py"} if here == HOME else {*here.glob("*.py"), *here.glob("*.so")}
    found |= {file.parent for file in here.glob("*/__init__.py") if here != HOME}
    if own and not (here / f"{own}.py").exists():
        found.add(here / own)  # a package without __init__.py
    found |= {path for path in also if path.parent == here}
    places = sorted(path for path in found if path.exists())
    for path in places:
        (folder / path.name).symlink_to(path)
    return places


def find_packages(modules: Iterable[str]) -> Iterator[Path]:
    """Yield the places of the packages of modules that are installed; nothing is imported."""
    for module in modules:
        spec = find_spec(module.partition(".")[0])
        if spec is not None and spec.origin is not None and (path := Path(spec.origin)).is_absolute():
            yield path.parent if path.name == "__init__.py" else path


def write_settings(config: Path, place: Path) -> None:
    """Write the settings of a config.yaml with its parts, without the seeds from which episodes could be drawn again."""
    place.write_text(yaml.safe_dump(_without_seeds(read_merged(with_parts(config))), sort_keys=False), encoding="utf-8")


def _without_seeds(tree: Any) -> Any:
    if not isinstance(tree, Mapping):
        return tree
    return {key: 0 if key == "seed" else _without_seeds(value) for key, value in tree.items()}


def _environment() -> Iterator[Path]:
    """Yield the places of Python, its packages and OVMAN, and what of the system programs need."""
    yield from map(Path, SYSTEM)
    yield from map(Path, (sys.prefix, sys.base_prefix))
    link = Path(sys.executable)
    while link.is_symlink():  # it may lead through folders that are links
        link = link.parent / link.readlink()
        yield link
    here = Path.cwd().resolve()
    roots = (here, HOME) if HOME != INSIDE else (here,)
    for entry in (*sys.path, *os.environ.get("LD_LIBRARY_PATH", "").split(":")):
        if entry and not any(root.is_relative_to(Path(entry).resolve()) for root in roots):
            yield Path(entry)
    yield from find_packages(PACKAGES)


def _shipped() -> Iterator[Path]:
    """Yield the shipped files of every OVMAN that is installed where Python looks."""
    for prefix in {sys.prefix, sys.base_prefix, "/usr", "/usr/local"}:
        for environment in ("", "envs/*/"):
            yield from Path(prefix).glob(f"{environment}lib*/python*/*-packages/ovman/{INSIDE.name}")
    yield from (INSIDE, *(Path(entry, "ovman", INSIDE.name) for entry in sys.path))


def _read_only(wanted: Iterable[Path], hidden: Iterable[Path]) -> tuple[list[Path], list[Path]]:
    """Return the places to read without what is hidden, and the folders that have hidden places: their names may be listed."""
    apart = {path.resolve() for path in hidden if path.exists()}
    read, listed = dict[Path, None](), dict[Path, None]()
    for path in wanted:
        for place in _carve(path, apart, listed):
            read[place] = None
    return [path for path in read if read.keys().isdisjoint(path.parents)], list(listed)


def _carve(path: Path, hidden: set[Path], listed: dict[Path, None]) -> Iterator[Path]:
    real = path.resolve()
    if not path.exists() or any(real.is_relative_to(place) for place in hidden):
        return
    if not any(place.is_relative_to(real) for place in hidden):
        yield path
        return
    listed[path] = None
    for inner in sorted(path.iterdir()):
        yield from _carve(inner, hidden, listed)
