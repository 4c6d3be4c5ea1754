"""The checks of `ovman doctor`. A check looks at one thing, never raises, and names the remedy."""

from __future__ import annotations

import importlib.metadata
import importlib.util
import json
import os
import platform
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any

from ovman.shipped import HOME
from ovman.sim import unity

FRAME_LIMIT_S = {"embedded": 120.0, "thor": 300.0}
"""Time limit for the first frames of a backend. The engine compiles kernels at first use, Unity's build shaders."""
NETWORKS_LIMIT_S = 180.0
"""Time limit for the networks. PyTorch, where it opens them, takes half a minute from a cold disk."""
SHORT_S = 30.0
"""Time limit for a small program."""
SETUP = "in a checkout of OVMAN: make setup"


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


class _ProbeError(Exception):
    """A probe that failed, with its last line; is_clear: the line names the remedy."""

    def __init__(self, line: str, is_clear: bool = False) -> None:
        super().__init__(line)
        self.line, self.is_clear = line, is_clear


def check_python() -> Finding:
    """Check the Python interpreter and the platform."""
    version = platform.python_version()
    if sys.platform != "linux":
        remedy = "the client's pipes work on Linux: use WSL2 or a container"
        return Finding("python", State.ILL, f"Python {version} on {sys.platform}", remedy)
    memory_gb = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return Finding("python", State.WELL, f"Python {version}, {os.cpu_count()} cores, {memory_gb:.0f} GB")


def check_client() -> Finding:
    """Check the ai2thor package and its folder, without which it fails before a simulator starts."""
    try:
        version = importlib.metadata.version("ai2thor")
    except importlib.metadata.PackageNotFoundError:
        return Finding("ai2thor", State.ILL, "not installed", "pip install ai2thor==5.0.0")
    store = Path.home() / ".ai2thor"
    if not os.access(store if store.exists() else store.parent, os.W_OK):
        return Finding("ai2thor", State.ILL, f"{version}; {store} cannot be written", "set HOME to a folder that can be written")
    return Finding("ai2thor", State.WELL, version)


def check_engine_process() -> Finding:
    """Check whether the process that the client starts can import the engine. If not, the client would wait forever."""
    from ovman_engine import executable

    environment = {k: v for k, v in os.environ.items() if not k.startswith("AI2THOR_")}
    try:
        done = subprocess.run(shlex.split(executable()), env=environment, capture_output=True, text=True, timeout=SHORT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        remedy = "the interpreter may have moved; make the environment again"
        return Finding("engine process", State.ILL, f"{type(error).__name__}: {error}".splitlines()[0], remedy)
    if done.returncode != 2 or "ovman-engine" not in done.stderr:
        remedy = "install the package (pip install -e .), or give PYTHONPATH as an absolute path"
        return Finding("engine process", State.ILL, _last_line(done.stderr), remedy)
    return Finding("engine process", State.WELL, "starts")


def check_frame(backend: str, subject: str, remedy: str) -> Finding:
    """Check one frame of a backend through the real Controller, within a time limit."""
    try:
        found = _probe("frame", backend, FRAME_LIMIT_S[backend])
    except _ProbeError as error:
        return Finding(subject, State.ILL, error.line, remedy)
    wide, high = found["size_px"]
    says = f"{wide} x {high} RGB, depth and ids in {found['frame_ms']:.0f} ms; {found['start_s']:.1f} s to the first"
    return Finding(subject, State.WELL, says)


def check_engine_frame() -> Finding:
    """Check a frame of the embedded engine."""
    return check_frame("embedded", "engine frame", "see the end of the engine's log, ~/.ai2thor/log/unity.log")


def check_benchmark() -> Finding:
    """Check the packages that the benchmark needs in addition to the engine."""
    names = ("snakemake", "pydantic", "yaml", "matplotlib", "pandas", "jinja2", "onnxruntime", "cv2")
    missing = [name for name in names if importlib.util.find_spec(name) is None]
    if missing:
        return Finding("benchmark", State.ABSENT, f"{', '.join(missing)} not installed", SETUP)
    return Finding("benchmark", State.WELL, f"snakemake {importlib.metadata.version('snakemake')}")


def check_perception(config: Path = HOME / "config.yaml") -> Finding:
    """Check both networks of the settings on one picture, within a time limit."""
    if not config.exists():
        return Finding("perception", State.ABSENT, f"{config} is missing; a checkout of the repository has it")
    try:
        found = _probe("networks", str(config), NETWORKS_LIMIT_S)
    except _ProbeError as error:
        says, _, remedy = error.line.rpartition("; ") if error.is_clear else (error.line, "", SETUP)
        return Finding("perception", State.ILL, says, remedy)
    libraries = ", ".join(f"{name.removesuffix('_torch')} {version}" for name, version in found["libraries"].items())
    return Finding(
        "perception",
        State.WELL,
        f"a picture in {found['detector_ms']:.0f} ms, a crop and a noun in {found['encoder_ms']:.0f} ms on {found['device']};"
        f" {found['start_s']:.1f} s to load; {libraries}",
    )


def check_gpu() -> Finding:
    """Check NVIDIA GPUs, which the default configuration does not need."""
    if shutil.which("nvidia-smi") is None:
        return Finding("gpu", State.ABSENT, "none; only Unity and the paper's weights need one")
    try:
        done = subprocess.run(["nvidia-smi", "-L"], capture_output=True, text=True, timeout=SHORT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        return Finding("gpu", State.ABSENT, f"nvidia-smi: {error}", "reload the driver")
    if done.returncode != 0 or not done.stdout.strip():
        return Finding("gpu", State.ABSENT, f"nvidia-smi: {_last_line(done.stdout + done.stderr)}", "reload the driver")
    return Finding("gpu", State.WELL, "; ".join(line.split(" (UUID")[0] for line in done.stdout.splitlines()))


def check_vulkan() -> Finding:
    """Check Vulkan, which Unity's CloudRendering build needs, and its GPUs."""
    try:
        found = unity.devices()
    except unity.Missing as missing:
        return Finding("vulkan", State.ILL, missing.what, missing.remedy)
    if found is None:
        remedy = "sudo apt install vulkan-tools names them; Unity does without"
        return Finding("vulkan", State.ABSENT, "the library is installed; vulkaninfo, which names the devices, is not", remedy)
    return Finding("vulkan", State.WELL, "; ".join(device.name for device in found if device.is_gpu))


def check_unity_build() -> Finding:
    """Check place and size of AI2-THOR's build; download a missing one."""
    if not unity.is_present():
        try:
            unity.fetch()
        except unity.Missing as missing:
            return Finding("unity build", State.ILL, missing.what, missing.remedy)
    where = Path(unity.build().base_dir)
    size = sum(file.stat().st_size for file in where.rglob("*") if file.is_file())
    return Finding("unity build", State.WELL, f"{where}, {size / 1e6:.0f} MB")


def check_unity_frame() -> Finding:
    """Check a frame of the Unity build."""
    log = "~/.config/unity3d/Allen Institute for Artificial Intelligence/AI2-THOR/Player.log"
    return check_frame("thor", "unity frame", f"see the checks above and the end of Unity's log, {log}")


Check = Callable[[], Finding]
ALWAYS: tuple[Check, ...] = (
    check_python,
    check_client,
    check_engine_process,
    check_engine_frame,
    check_benchmark,
    check_perception,
    check_gpu,
)
UNITY: tuple[Check, ...] = (check_vulkan, check_unity_build, check_unity_frame)
NEEDS: dict[Check, set[str]] = {
    check_engine_frame: {"ai2thor", "engine process"},
    check_unity_build: {"ai2thor", "vulkan"},
    check_unity_frame: {"ai2thor", "vulkan", "unity build"},
}
"""Subjects that must not be ILL before a check runs."""


def run_checks(thor: bool = False) -> Iterator[Finding]:
    """Yield the results, one after the other. A check whose requirements are ILL is not run."""
    ill: set[str] = set()
    for check in (*ALWAYS, *(UNITY if thor else ())):
        if first := sorted(NEEDS.get(check, set()) & ill):
            subject = check.__name__.removeprefix("check_").replace("_", " ")
            yield Finding(subject, State.ILL, f"not tried: {', '.join(first)} first")
            continue
        found = check()
        if found.state is State.ILL:
            ill.add(found.subject)
        yield found


def format_findings(found: Sequence[Finding]) -> str:
    """Return the results as lines: state, subject and finding, and the remedy below."""
    lines = []
    for f in found:
        lines.append(f"{f.state.value}  {f.subject:<16}{f.says}")
        if f.remedy:
            lines.append(f"{'':20}-> {f.remedy}")
    return "\n".join(lines)


def check_simulator(output: Path) -> None:
    """Check the Unity build with one frame, once and before any scene needs it, and write the results to `output`.

    Raises:
        unity.Missing: The first problem, one line with the remedy.
    """
    found = []
    for check in UNITY:
        found.append(check())
        print(format_findings(found[-1:]), flush=True)
        if found[-1].state is State.ILL:
            raise unity.Missing(found[-1].says, found[-1].remedy)
    output.write_text(format_findings(found) + "\n")


def _probe(what: str, argument: str, limit_s: float) -> dict[str, Any]:
    """Return the result of a probe, which is ended with all its processes after a time limit. Raises _ProbeError."""
    command = [sys.executable, "-m", "ovman.doctor.probe", what, argument]
    probe = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        out, err = probe.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        os.killpg(probe.pid, signal.SIGKILL)
        probe.communicate()
        raise _ProbeError(f"no {'frame' if what == 'frame' else 'picture'} within {limit_s:g} s") from None
    if probe.returncode != 0:
        raise _ProbeError(_last_line(err), is_clear=probe.returncode == 2)
    found: dict[str, Any] = json.loads(out.splitlines()[-1])
    return found


def _last_line(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it ended without output"
