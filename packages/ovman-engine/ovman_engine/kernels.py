"""Compiles the kernels that draw, before a client waits for its first image.

Numba compiles a function at its first call and caches the result for later processes. Compiling all of them takes half a minute,
and several on a busy machine: longer than a client waits for an answer by default, but not longer than it waits for an engine to
start.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from importlib import import_module
from importlib.metadata import version
from pathlib import Path

SCENES = "FloorPlan212", "FloorPlan425"
"""The first has sunshine and lamps; the second has a mirror, glass and a movable object."""
ROOMS = "paint", "picture"
"""Packages with compiled functions."""
UNUSED = "scipy.linalg", "coverage"
"""What numba imports if it can."""
SIDE_PX = 48
KINDS = ("renderDepthImage", "renderInstanceSegmentation", "renderSemanticSegmentation", "renderNormalsImage")


def without_blas() -> None:
    """Let numba start without what no kernel needs.

    Numba takes SciPy's linear algebra and coverage where they are installed. They take 0.15 s of the processor, and no kernel
    multiplies matrices.
    """
    if "numba.np.arraymath" in sys.modules:
        return
    absent = [name for name in UNUSED if name not in sys.modules]
    sys.modules.update(dict.fromkeys(absent))  # type: ignore[arg-type]  # numba takes them for not installed
    try:
        import_module("numba.np.arraymath")
    finally:
        for name in absent:
            del sys.modules[name]


def ready() -> bool:
    """Whether an earlier process compiled the current kernels on this type of processor."""
    return _mark().exists()


def compile_once() -> None:
    """Compiles all kernels, or waits for the process that is compiling them: engines of a fresh machine are started together."""
    with _alone():
        if not ready():
            compile_all()


def compile_all() -> None:
    """Call every kernel once, by drawing small images, and leaves a mark."""
    from ovman_engine.engine import Engine

    engine = Engine(SIDE_PX, SIDE_PX)

    def do(action: str, **arguments: object) -> None:
        engine.answer(json.dumps({"action": action, **arguments}).encode())

    for scene in SCENES:
        do("Reset", sceneName=f"{scene}_physics")
        do("Initialize", **dict.fromkeys(KINDS, True))
        for _ in range(4):
            do("RotateRight")
    moved = next(b for b in engine.session.world.bodies.values() if b.dynamic)
    x, y, z = (float(v) for v in moved.pose.position)
    do("TeleportObject", objectId=moved.object_id, position={"x": x, "y": y + 0.3, "z": z}, forceAction=True)
    do("ToggleMapView")
    do("ToggleMapView")
    do("AddThirdPartyCamera", position={"x": x, "y": y + 1, "z": z}, rotation={"x": 30, "y": 40, "z": 10}, fieldOfView=60)
    do("GetInteractablePoses", objectId=moved.object_id, maxPoses=1)
    with suppress(OSError):  # a read-only folder: the next engine compiles again
        mark = _mark()
        mark.parent.mkdir(parents=True, exist_ok=True)
        for old in mark.parent.glob("kernels-*"):
            old.unlink()
        mark.touch()


@contextmanager
def _alone() -> Iterator[None]:
    """No other process is in here; the kernel lets go of the lock however its holder ends. In a read-only folder, no lock."""
    path = _mark().with_name("kernels.lock")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        file = path.open("a")
    except OSError:
        yield
        return
    with file:
        fcntl.flock(file, fcntl.LOCK_EX)
        yield


def _mark() -> Path:
    """Path of the mark. It lies beside Numba's cache, so that deleting the cache deletes the mark."""
    here = Path(__file__).parent
    files = sorted(p for room in ROOMS for p in (here / room).glob("*.py"))
    sources = [(p.name, p.stat().st_mtime_ns, p.stat().st_size) for p in files]
    digest = hashlib.sha256(repr((sources, version("numba"), sys.version_info[:3], _processor())).encode()).hexdigest()[:16]
    kept = os.environ.get("NUMBA_CACHE_DIR")
    if kept:
        folder = Path(kept)
    elif os.access(here, os.W_OK):
        folder = here / "__pycache__"
    else:
        folder = Path.home() / ".cache" / "ovman"
    return folder / f"kernels-{digest}"


def _processor() -> str:
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text().splitlines():
            if line.startswith("model name"):
                return line
    return platform.machine()
