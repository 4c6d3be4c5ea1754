"""Starts simulators. All other code is the same for the embedded engine and for Unity."""

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

Start = Callable[[str, str | dict[str, Any], Embodiment], Any]
"""Type of `start`: from backend, scene and embodiment to a Controller or an object with its methods."""
BACKENDS = ("embedded", "thor")
"""Simulators: this project's engine, AI2-THOR's Unity build."""
START_LIMIT_S = 600.0
"""Time limit from the start of a simulator to its first scene; the engine compiles its kernels once."""
WATCH_S = 0.2
"""Seconds between two looks at a start."""
ENDING_S = 1.0
"""Time limit for the end of a process after its pipes were closed."""
NONSENSE = bytes(5)
"""A wire frame of unknown type."""


def start(backend: str, scene: str | dict[str, Any], embodiment: Embodiment) -> Controller:
    """Start an ai2thor Controller on a scene with the body and camera of `embodiment`. backend, errors: as for `launched`.

    scene: the name of a floor plan, or a house of ProcTHOR's schema.
    """
    sizes = {"width": embodiment.width_px, "height": embodiment.height_px}
    made = launched(controller_class(), backend, scene=scene, **sizes, **embodiment.initialization())
    if backend == "thor":
        _lengthen_depth(made)
    return made


def controller_class() -> type[Controller]:
    """Import the client's class of Controllers."""
    from ai2thor.controller import Controller

    found: type[Controller] = Controller
    return found


def launched(kind: type[Controller], backend: str, **options: Any) -> Controller:
    """Return a running Controller of class `kind`. options: parameters of the Controller.

    backend: "embedded" (this project's engine, CPU) or "thor" (the Unity build through CloudRendering, GPU). Raises ValueError
    for another backend; unity.Missing, a ValueError, if the machine lacks a requirement or the build; ConnectionError
    if the simulator ends during its start or does not start within START_LIMIT_S.
    """
    if backend == "embedded":
        from ovman_engine import executable

        # The client requires Vulkan if the environment names a GPU.
        hidden = os.environ.pop("CUDA_VISIBLE_DEVICES", None)
        try:
            # Without a time limit the client takes the end of a pipe for the end of the engine; with one it waits for the limit.
            return _started(kind, local_executable_path=executable(), server_timeout=None, **options)
        finally:
            if hidden is not None:
                os.environ["CUDA_VISIBLE_DEVICES"] = hidden
    if backend == "thor":
        from ai2thor.platform import CloudRendering

        from ovman.sim import unity

        unity.find_gpus()
        unity.fetch()
        return _started(kind, platform=CloudRendering, **options)
    raise ValueError(f"benchmark.backend: {backend!r} is not one of {', '.join(BACKENDS)}")


def masks_only(backend: str) -> dict[str, Any]:
    """Arguments of a step that asks for instance masks alone. Empty for Unity, which has no such option."""
    if backend != "embedded":
        return {}
    from ovman_engine import MASKS_ONLY

    return {MASKS_ONLY: True}


def ended(controller: Controller) -> bool:
    """Return whether the process of a Controller's simulator has ended; waits up to ENDING_S for an end under way."""
    process = getattr(vars(controller).get("server"), "unity_proc", None)
    try:
        return process is not None and process.wait(ENDING_S) is not None
    except subprocess.TimeoutExpired:
        return False


def _lengthen_depth(made: Controller) -> None:
    """Correct the depth images of `made`: at z metres Unity gives z (far - near) / far, the corrected image gives z."""
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
    """Return a Controller of these options. ConnectionError if its simulator ends meanwhile, or takes longer than START_LIMIT_S.

    The client would wait forever for a simulator that does not open its pipes. A failed start leaves no process.
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
    """Send an invalid frame to a client whose simulator ended during its start: an end of file alone takes it minutes to accept.

    A simulator that exceeds START_LIMIT_S is killed first.
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
