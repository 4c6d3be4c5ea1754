"""The one place that starts a simulator. Everything after it is the same for the embedded engine and for Unity."""

from __future__ import annotations

import os
import subprocess
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from typing import TYPE_CHECKING, Any

import numpy as np

from ovman.sim.embodiment import Embodiment

if TYPE_CHECKING:
    from ai2thor.controller import Controller

Start = Callable[[str, str, Embodiment], Any]
"""What `start` is: backend, scene and embodiment to a Controller, or to what answers as one."""
BACKENDS = ("embedded", "thor")
START_LIMIT_S = 600.0
"""How long a simulator may take to its first scene; the engine compiles its kernels once."""
WATCH_S = 0.2
"""How often a start is looked at."""
ENDING_S = 1.0
"""How long a process may take to end after its pipes have been closed."""
NONSENSE = bytes(5)
"""A frame of a type that there is not."""


def start(backend: str, scene: str, embodiment: Embodiment) -> Controller:
    """A running ai2thor Controller on `scene`, with a body and a camera. `backend` as for `launched`."""
    from ai2thor.controller import Controller

    sizes = {"width": embodiment.width_px, "height": embodiment.height_px}
    made = launched(Controller, backend, scene=scene, **sizes, **embodiment.initialization())
    if backend == "thor":
        _lengthen_depth(made)
    return made


def launched(kind: type[Controller], backend: str, **options: Any) -> Controller:
    """A running Controller of `kind` with parameters of its own.

    `backend` is "embedded" (this project's engine, CPU) or "thor" (the Unity build through CloudRendering, GPU). ValueError for
    another backend; unity.Missing, which is one, where the machine lacks something or the build cannot be had; ConnectionError if
    the simulator ends meanwhile, or is not there within START_LIMIT_S.
    """
    if backend == "embedded":
        from ovman_engine import executable

        # The client asks for Vulkan if it sees a GPU.
        hidden = os.environ.pop("CUDA_VISIBLE_DEVICES", None)
        try:
            # Without a time limit the end of a pipe is the end of the engine; with one, the client waits for the limit.
            return _started(kind, local_executable_path=executable(), server_timeout=None, **options)
        finally:
            if hidden is not None:
                os.environ["CUDA_VISIBLE_DEVICES"] = hidden
    if backend == "thor":
        from ai2thor.platform import CloudRendering

        from ovman.sim import unity

        unity.devices()
        unity.fetch()
        return _started(kind, platform=CloudRendering, **options)
    raise ValueError(f"benchmark.backend: {backend!r} is not one of {', '.join(BACKENDS)}")


def masks_only(backend: str) -> dict[str, Any]:
    """Arguments of a step of whose image only the instance masks are wanted. Unity draws all or nothing: it is not asked."""
    if backend != "embedded":
        return {}
    from ovman_engine import MASKS_ONLY

    return {MASKS_ONLY: True}


def ended(controller: Controller) -> bool:
    """Whether the process of a Controller's simulator has ended. Asked when something went wrong: an end under way is awaited."""
    process = getattr(vars(controller).get("server"), "unity_proc", None)
    try:
        return process is not None and process.wait(ENDING_S) is not None
    except subprocess.TimeoutExpired:
        return False


def _lengthen_depth(made: Controller) -> None:
    """Unity's depth at z metres reads z (far - near) / far. From now on every depth image of `made` is z."""
    server = made.server
    read = server.create_event
    scale = np.float32(server.camera_far_plane / (server.camera_far_plane - server.camera_near_plane))

    def event(metadata: Any, files: Any) -> Any:
        made_of = read(metadata, files)
        if made_of.depth_frame is not None:
            made_of.depth_frame = made_of.depth_frame * scale
        made_of.third_party_depth_frames = [depth * scale for depth in made_of.third_party_depth_frames]
        return made_of

    server.create_event = event


def _started(kind: type[Controller], **options: Any) -> Controller:
    """A Controller of these options. ConnectionError if its simulator ends meanwhile, or takes longer than START_LIMIT_S.

    A simulator that ends before it has opened its pipes would leave the client opening them for ever, and so would one that never
    opens them. What is left of a failed start is ended.
    """
    made: Controller = object.__new__(kind)
    done = threading.Event()
    watch = threading.Thread(target=_let_go, args=(made, done), name="watch-start", daemon=True)
    watch.start()
    try:
        made.__init__(**options)
    except BaseException as error:
        died = isinstance(error, Exception) and ended(made)
        with suppress(Exception):
            made.stop()
        if died:
            raise ConnectionError(f"The simulator ended while it was being started: {type(error).__name__}: {error}") from error
        raise
    finally:
        done.set()
        watch.join()
    return made


def _let_go(starting: Controller, done: threading.Event) -> None:
    """Says nonsense to a client whose simulator has ended during its start: an end of file it would not believe for minutes.

    A simulator that takes too long is ended first.
    """
    begun = None
    while not done.wait(WATCH_S):
        server = vars(starting).get("server")
        process = getattr(server, "unity_proc", None)
        if process is None:
            continue
        begun = begun or time.monotonic()
        if process.poll() is None and time.monotonic() - begun > START_LIMIT_S:
            process.kill()
        if process.poll() is None:
            continue
        for path, way in ((server.server_pipe_path, os.O_WRONLY), (server.client_pipe_path, os.O_RDONLY)):
            with suppress(OSError):
                pipe = os.open(path, way | os.O_NONBLOCK)
                with suppress(OSError):
                    os.write(pipe, NONSENSE)
                os.close(pipe)
