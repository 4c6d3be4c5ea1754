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

from ovman.perception.libraries import cache
from ovman.shipped import HOME
from ovman.sim import unity

FRAME_LIMIT_S = {"embedded": 120.0, "thor": 300.0}
"""Time limit for the first frames of a backend. The engine compiles kernels at first use, Unity's build shaders."""
NETWORKS_LIMIT_S = 180.0
"""Time limit for the first picture through the networks. PyTorch, where it opens them, takes half a minute from a cold disk."""
NETWORK_LIBRARIES = ("onnxruntime", "cv2")
SHORT_S = 30.0
"""Time limit for a small program."""


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


def python() -> Finding:
    """The Python interpreter and the platform."""
    version = platform.python_version()
    if sys.platform != "linux":
        remedy = "the client's pipes work on Linux: use WSL2 or a container"
        return Finding("python", State.ILL, f"Python {version} on {sys.platform}", remedy)
    return Finding("python", State.WELL, f"Python {version}, {os.cpu_count()} cores, {_memory_gb():.0f} GB")


def client() -> Finding:
    """The ai2thor package, and conditions under which it fails before a simulator starts."""
    try:
        version = importlib.metadata.version("ai2thor")
    except importlib.metadata.PackageNotFoundError:
        return Finding("ai2thor", State.ILL, "not installed", "pip install ai2thor==5.0.0")
    home = Path.home()
    store = home / ".ai2thor"
    if not os.access(store if store.exists() else home, os.W_OK):
        return Finding("ai2thor", State.ILL, f"{version}; {store} cannot be written", "set HOME to a folder that can be written")
    devices = os.environ.get("CUDA_VISIBLE_DEVICES", "")
    if any(d.strip().isdigit() for d in devices.split(",")) and shutil.which("vulkaninfo") is None:
        return Finding(
            "ai2thor", State.ABSENT, f"{version}; it would ask for Vulkan because CUDA_VISIBLE_DEVICES is {devices}",
            "take CUDA_VISIBLE_DEVICES out of os.environ while a Controller is made (OVMAN's own programs do)",
        )  # fmt: skip
    return Finding("ai2thor", State.WELL, version)


def engine_process() -> Finding:
    """Whether the process that the client starts can import the engine. If not, the client would wait forever."""
    from ovman_engine import executable

    environment = {k: v for k, v in os.environ.items() if not k.startswith("AI2THOR_")}
    try:
        done = subprocess.run(shlex.split(executable()), env=environment, capture_output=True, text=True, timeout=SHORT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        return Finding("engine process", State.ILL, _line(error), "the interpreter may have moved; make the environment again")
    if done.returncode != 2 or "ovman-engine" not in done.stderr:
        return Finding(
            "engine process", State.ILL, _last(done.stderr),
            "install the package (pip install -e .), or give PYTHONPATH as an absolute path",
        )  # fmt: skip
    return Finding("engine process", State.WELL, "starts")


def frame(backend: str, subject: str, remedy: str) -> Finding:
    """One frame of a backend through the real Controller, within a time limit."""
    limit = FRAME_LIMIT_S[backend]
    command = [sys.executable, "-m", "ovman.doctor.probe", backend]
    probe = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    try:
        out, err = probe.communicate(timeout=limit)
    except subprocess.TimeoutExpired:
        os.killpg(probe.pid, signal.SIGKILL)
        probe.communicate()
        return Finding(subject, State.ILL, f"no frame within {limit:g} s", remedy)
    if probe.returncode != 0:
        return Finding(subject, State.ILL, _last(err), remedy)
    found = json.loads(out.splitlines()[-1])
    wide, high = found["size_px"]
    return Finding(
        subject, State.WELL,
        f"{wide} x {high} RGB, depth and ids in {found['frame_ms']:.0f} ms; {found['start_s']:.1f} s to the first;"
        f" {found['resident_mb']:.0f} MB",
    )  # fmt: skip


def engine_frame() -> Finding:
    """A frame of the embedded engine."""
    return frame("embedded", "engine frame", "see the end of the engine's log, ~/.ai2thor/log/unity.log")


def workflow() -> Finding:
    """The packages of the benchmark beside the engine."""
    missing = [
        name
        for name in ("snakemake", "pydantic", "yaml", "matplotlib", "pandas", "jinja2")
        if importlib.util.find_spec(name) is None
    ]
    if missing:
        return Finding("benchmark", State.ABSENT, f"{', '.join(missing)} not installed", "in a checkout of OVMAN: make setup")
    return Finding("benchmark", State.WELL, f"snakemake {importlib.metadata.version('snakemake')}")


def gpu() -> Finding:
    """NVIDIA GPUs. The default configuration needs none."""
    if shutil.which("nvidia-smi") is None:
        return Finding("gpu", State.ABSENT, "none; only Unity and the paper's weights want one")
    try:
        done = subprocess.run(["nvidia-smi", "-L"], capture_output=True, text=True, timeout=SHORT_S)
    except (OSError, subprocess.TimeoutExpired) as error:
        return Finding("gpu", State.ABSENT, f"nvidia-smi: {_line(error)}", "reload the driver")
    if done.returncode != 0 or not done.stdout.strip():
        return Finding("gpu", State.ABSENT, f"nvidia-smi: {_last(done.stdout + done.stderr)}", "reload the driver")
    return Finding("gpu", State.WELL, "; ".join(line.split(" (UUID")[0] for line in done.stdout.splitlines()))


def perception(config: Path | None = None) -> Finding:
    """Both networks of the settings on one picture, within a time limit."""
    missing = [name for name in NETWORK_LIBRARIES if importlib.util.find_spec(name) is None]
    if missing:
        return Finding("perception", State.ABSENT, f"{', '.join(missing)} not installed", "in a checkout of OVMAN: make setup")
    file = HOME / "config.yaml" if config is None else config
    if not file.exists():
        return Finding("perception", State.ABSENT, "no config.yaml beside the package; a checkout of the repository has one")
    command = [sys.executable, "-m", "ovman.doctor.networks", str(file)]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=NETWORKS_LIMIT_S)
    except subprocess.TimeoutExpired:
        return Finding(
            "perception", State.ILL, f"no picture within {NETWORKS_LIMIT_S:g} s", "install the libraries anew: make setup"
        )
    if done.returncode == 2:
        says, _, remedy = _last(done.stderr).rpartition("; ")
        return Finding("perception", State.ILL, says, remedy)
    if done.returncode != 0:
        return Finding("perception", State.ILL, _last(done.stderr), "install the libraries anew: make setup")
    found = json.loads(done.stdout.splitlines()[-1])
    libraries = ", ".join(f"{name.removesuffix('_torch')} {version}" for name, version in found["libraries"].items())
    return Finding(
        "perception", State.WELL,
        f"a picture in {found['detector_ms']:.0f} ms, a crop and a noun in {found['encoder_ms']:.0f} ms on {found['device']};"
        f" {found['start_s']:.1f} s to load; {libraries}",
    )  # fmt: skip


def weights() -> Finding:
    """The downloaded networks of the paper."""
    hub = Path(os.environ.get("HF_HOME") or cache().with_name("huggingface")) / "hub"
    wanted = {
        "yolov8m-seg": any(cache().glob("*/yolov8m-seg.pt")),
        "ViT-B-16 laion2b_s34b_b88k": (hub / "models--laion--CLIP-ViT-B-16-laion2B-s34B-b88K").exists(),
    }
    if all(wanted.values()):
        return Finding("paper's weights", State.WELL, ", ".join(wanted))
    missing = ", ".join(name for name, there in wanted.items() if not there)
    return Finding("paper's weights", State.ABSENT, f"{missing} not there; only overlays/thor.yaml asks for them")


def vulkan() -> Finding:
    """Vulkan, which Unity's CloudRendering build needs, and its GPUs."""
    try:
        found = unity.devices()
    except unity.Missing as missing:
        return Finding("vulkan", State.ILL, missing.what, missing.remedy)
    if found is None:
        remedy = "sudo apt install vulkan-tools names them; Unity does without"
        return Finding("vulkan", State.ABSENT, "the library is installed; vulkaninfo, which names the devices, is not", remedy)
    return Finding("vulkan", State.WELL, "; ".join(device.name for device in found if device.is_gpu))


def unity_build() -> Finding:
    """AI2-THOR's build: place and size. A missing build is downloaded."""
    where = Path(unity.build().base_dir)
    if not unity.is_present():
        try:
            unity.fetch()
        except unity.Missing as missing:
            return Finding("unity build", State.ILL, missing.what, missing.remedy)
    size = sum(file.stat().st_size for file in where.rglob("*") if file.is_file())
    return Finding("unity build", State.WELL, f"{where}, {size / 1e6:.0f} MB")


def unity_frame() -> Finding:
    """A frame of the Unity build."""
    log = "~/.config/unity3d/Allen Institute for Artificial Intelligence/AI2-THOR/Player.log"
    return frame("thor", "unity frame", f"see the checks above and the end of Unity's log, {log}")


HERE: tuple[Callable[[], Finding], ...] = (python, client, engine_process, engine_frame, workflow, perception, weights, gpu)
"""Checks that always run."""
UNITY: tuple[Callable[[], Finding], ...] = (vulkan, unity_build, unity_frame)
"""Checks of Unity's build."""


NEEDS = {
    engine_frame: frozenset({"ai2thor", "engine process"}),
    unity_build: frozenset({"ai2thor", "vulkan"}),
    unity_frame: frozenset({"ai2thor", "vulkan", "unity build"}),
}
"""Checks that must not be ILL before another one runs."""


def findings(thor: bool = False) -> Iterator[Finding]:
    """The results, one after the other. A check whose requirements are ILL is not run."""
    ill: set[str] = set()
    for check in (*HERE, *(UNITY if thor else ())):
        needs = NEEDS.get(check, frozenset())
        if needs & ill:
            yield Finding(check.__name__.replace("_", " "), State.ILL, f"not tried: {', '.join(sorted(needs & ill))} first")
            continue
        found = check()
        if found.state is State.ILL:
            ill.add(found.subject)
        yield found


def report(found: Sequence[Finding]) -> str:
    """The results as lines: state, subject and finding, and the remedy below."""
    lines = []
    for f in found:
        lines.append(f"{f.state.value}  {f.subject:<16}{f.says}")
        if f.remedy:
            lines.append(f"{'':20}-> {f.remedy}")
    return "\n".join(lines)


def _line(error: Exception) -> str:
    return f"{type(error).__name__}: {error}".splitlines()[0]


def _last(text: str) -> str:
    lines = [line.strip() for line in text.splitlines() if line.strip()]
    return lines[-1] if lines else "it ended without output"


def _memory_gb() -> float:
    return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
