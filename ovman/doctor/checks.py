"""The checks of `ovman doctor`. A check looks at one thing and returns what it found, or raises what is wrong with the remedy."""

from __future__ import annotations

import importlib.metadata
import json
import os
import platform
import shlex
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from enum import Enum
from functools import partial
from pathlib import Path
from typing import Any

from ovman.remote.isolation import Isolation, unavailable
from ovman.shipped import HOME
from ovman.sim import unity

FRAME_LIMIT_S = {"embedded": 120.0, "thor": 300.0}
"""Time limit for the first frames of a backend. Unity's build compiles shaders at first use."""
NETWORKS_LIMIT_S = 180.0
"""Time limit for the networks. PyTorch, where it opens them, takes half a minute from a cold disk."""
SHORT_S = 30.0
"""Time limit for a small program."""
ENGINE_LOG = "see the end of the engine's log, ~/.ai2thor/log/unity.log"
UNITY_LOG = "~/.config/unity3d/Allen Institute for Artificial Intelligence/AI2-THOR/Player.log"


class State(Enum):
    """WELL: works. ABSENT: missing, and needed only by some features. ILL: does not work."""

    WELL = "ok"
    ABSENT = "--"
    ILL = "NO"


@dataclass(frozen=True)
class Finding:
    """The result of a check in one line, with the remedy if there is a problem."""

    subject: str
    state: State
    says: str
    remedy: str = ""


class Problem(Exception):
    """A fault of the machine, with its remedy."""

    def __init__(self, says: str, remedy: str, state: State = State.ILL) -> None:
        super().__init__(says)
        self.says, self.remedy, self.state = says, remedy, state


def check_python() -> str:
    """Check the Python interpreter and the platform."""
    version = platform.python_version()
    if sys.platform != "linux":
        raise Problem(f"Python {version} on {sys.platform}", "the client's pipes work on Linux: use WSL2 or a container")
    memory_gb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return f"Python {version}, {os.cpu_count()} cores, {memory_gb:.0f} GB"


def check_client() -> str:
    """Check the ai2thor package and its folder, without which it fails before a simulator starts."""
    try:
        version = importlib.metadata.version("ai2thor")
    except importlib.metadata.PackageNotFoundError:
        raise Problem("not installed", "pip install ai2thor==5.0.0") from None
    store = Path.home() / ".ai2thor"
    if not os.access(store if store.exists() else store.parent, os.W_OK):
        raise Problem(f"{version}; {store} cannot be written", "set HOME to a folder that can be written")
    return version


def check_engine_process() -> str:
    """Check whether the process that the client starts can import the engine. If not, the client would wait forever."""
    from ovman_engine import executable

    environment = {k: v for k, v in os.environ.items() if not k.startswith("AI2THOR_")}
    try:
        done = subprocess.run(shlex.split(executable()), env=environment, capture_output=True, text=True, timeout=SHORT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        says = f"{type(error).__name__}: {error}".splitlines()[0]
        raise Problem(says, "the interpreter may have moved; make the environment again") from None
    if done.returncode != 2 or "ovman-engine" not in done.stderr:
        remedy = "install the package (pip install -e .), or give PYTHONPATH as an absolute path"
        raise Problem(_last_line(done.stderr), remedy)
    return "starts"


def check_frame(backend: str, remedy: str) -> str:
    """Check one frame of a backend through the real Controller, within a time limit."""
    found = _probe("frame", backend, FRAME_LIMIT_S[backend], remedy)
    wide, high = found["size_px"]
    return f"{wide} x {high} RGB, depth and ids in {found['frame_ms']:.0f} ms; {found['start_s']:.1f} s to the first"


def check_perception(config: Path = HOME / "config.yaml") -> str:
    """Check both networks of the settings on one picture, within a time limit."""
    found = _probe("networks", str(config), NETWORKS_LIMIT_S, "in a checkout of OVMAN: make setup")
    libraries = ", ".join(f"{name.removesuffix('_torch')} {version}" for name, version in found["libraries"].items())
    return (
        f"a picture in {found['detector_ms']:.0f} ms, a crop and a noun in {found['encoder_ms']:.0f} ms on {found['device']};"
        f" {found['start_s']:.1f} s to load; {libraries}"
    )


def check_vulkan() -> str:
    """Check Vulkan, which Unity's CloudRendering build needs, and its GPUs."""
    found = unity.find_gpus()
    if found is None:
        remedy = "sudo apt install vulkan-tools names them; Unity does without"
        says = "the library is installed; vulkaninfo, which names the devices, is not"
        raise Problem(says, remedy, State.ABSENT)
    return "; ".join(found)


def check_unity_build() -> str:
    """Check place and size of AI2-THOR's build; download a missing one."""
    unity.fetch()
    where = Path(unity.build().base_dir)
    size = sum(file.stat().st_size for file in where.rglob("*") if file.is_file())
    return f"{where}, {size / 1e6:.0f} MB"


def check_isolation() -> str:
    """Check by which means agents of others can be isolated."""
    found = {level: unavailable(level) for level in Isolation if level is not Isolation.NONE}
    able = [level for level, why in found.items() if why is None]
    if not able:
        raise Problem("agents of others are not isolated", "; ".join(map(str, found.values())), State.ABSENT)
    return f"agents of others run under {able[0]}; available: {', '.join(able)}"


CHECKS: Mapping[str, Callable[[], str]] = {
    "python": check_python,
    "ai2thor": check_client,
    "engine process": check_engine_process,
    "engine frame": partial(check_frame, "embedded", ENGINE_LOG),
    "perception": check_perception,
    "isolation": check_isolation,
    "vulkan": check_vulkan,
    "unity build": check_unity_build,
    "unity frame": partial(check_frame, "thor", f"see the checks above and the end of Unity's log, {UNITY_LOG}"),
}
UNITY = ("vulkan", "unity build", "unity frame")
NEEDS = {
    "engine frame": {"ai2thor", "engine process"},
    "unity build": {"ai2thor", "vulkan"},
    "unity frame": {"ai2thor", "vulkan", "unity build"},
}
"""Subjects that must not be ILL before a check runs."""


def run_check(subject: str) -> Finding:
    """Return the result of one check."""
    try:
        return Finding(subject, State.WELL, CHECKS[subject]())
    except Problem as problem:
        return Finding(subject, problem.state, problem.says, problem.remedy)
    except unity.Missing as missing:
        return Finding(subject, State.ILL, missing.what, missing.remedy)


def run_checks(thor: bool = False) -> Iterator[Finding]:
    """Yield the results, one after the other. A check whose requirements are ILL is not run."""
    ill: set[str] = set()
    for subject in CHECKS:
        if subject in UNITY and not thor:
            continue
        if first := sorted(NEEDS.get(subject, set()) & ill):
            yield Finding(subject, State.ILL, f"not tried: {', '.join(first)} first")
            continue
        found = run_check(subject)
        if found.state is State.ILL:
            ill.add(subject)
        yield found


def format_finding(found: Finding) -> str:
    """Return a result as lines: state, subject and finding, and the remedy below."""
    line = f"{found.state.value}  {found.subject:<16}{found.says}"
    return f"{line}\n{'':20}-> {found.remedy}" if found.remedy else line


def check_simulator(output: Path) -> None:
    """Check the Unity build with one frame, once and before any scene needs it, and write the results to `output`.

    Raises:
        unity.Missing: The first problem, one line with the remedy.
    """
    lines = []
    for subject in UNITY:
        found = run_check(subject)
        lines.append(format_finding(found))
        print(lines[-1], flush=True)
        if found.state is State.ILL:
            raise unity.Missing(found.says, found.remedy)
    output.write_text("\n".join(lines) + "\n")


def _probe(what: str, argument: str, limit_s: float, remedy: str) -> dict[str, Any]:
    """Return the result of a probe, which is ended with all its processes after a time limit.

    Raises:
        Problem: It failed. The remedy is that of the probe's last line, if the probe says that this line has one.
    """
    command = [sys.executable, "-m", "ovman.doctor.probe", what, argument]
    probe = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        out, err = probe.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        os.killpg(probe.pid, signal.SIGKILL)
        probe.communicate()
        raise Problem(f"no {'frame' if what == 'frame' else 'picture'} within {limit_s:g} s", remedy) from None
    if probe.returncode == 2:
        says, _, remedy = _last_line(err).rpartition("; ")
        raise Problem(says, remedy)
    if probe.returncode != 0:
        raise Problem(_last_line(err), remedy)
    found: dict[str, Any] = json.loads(out.splitlines()[-1])
    return found


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it ended without output"
