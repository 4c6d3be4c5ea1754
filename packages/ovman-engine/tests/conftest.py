"""The real ai2thor Controller with the engine's own process, and the engine without its process.

Hypothesis draws the same examples in every run, so that a failure comes from a change of the code; `pytest --hypothesis-profile
default` draws others.
"""

from __future__ import annotations

import json
import os
import subprocess
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

import msgpack
import pytest
from hypothesis import settings

from ovman_engine import executable
from ovman_engine.client.wire import Field
from ovman_engine.engine import Engine

settings.register_profile("same", derandomize=True, deadline=None, max_examples=30)
settings.load_profile("same")

BARS = {"snapToGrid": False, "rotateStepDegrees": 30, "renderDepthImage": True, "renderInstanceSegmentation": True}
"""Initialize arguments of the benchmark."""


@pytest.fixture(scope="session", autouse=True)
def display(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """What the client needs: a display by name, no visible GPU, and a home directory for its log."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("DISPLAY", ":0")
        patch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
        patch.setenv("HOME", str(tmp_path_factory.mktemp("home")))
        yield


@contextmanager
def started(**options: Any) -> Iterator[Any]:
    """Start an engine as a client does, also where other tests of this process have engines forked."""
    from ai2thor import controller

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(controller, "subprocess", subprocess)
        made = controller.Controller(**{"local_executable_path": executable(), "server_timeout": 60} | options)
    try:
        yield made
    finally:
        with suppress(BrokenPipeError):
            made.stop()


@pytest.fixture(scope="session")
def start() -> Callable[..., Any]:
    """Context manager: `with start(scene=..., ...) as controller`."""
    return started


@pytest.fixture(scope="session")
def shared(display: None) -> Iterator[Any]:
    """The one Controller that tests share. A test that uses it resets it first."""
    with started() as controller:
        yield controller


def fresh(controller: Any, scene: Any, width: int = 300, height: int = 300, **initialize: Any) -> Any:
    """Reset a Controller to a scene, whatever was set before."""
    controller.initialization_parameters = {}
    controller.reset(scene, width=width, height=height, **initialize)
    return controller


@pytest.fixture(scope="session")
def reset(shared: Any) -> Callable[..., Any]:
    """`reset(scene, width=..., ...)`: the shared Controller on an untouched scene."""
    return lambda *scene, **options: fresh(shared, *scene, **options)


@pytest.fixture
def controller(reset: Callable[..., Any]) -> Any:
    """The shared Controller on the untouched FloorPlan201, as the benchmark starts it."""
    return reset("FloorPlan201", renderImage=False, **BARS)


class InProcess:
    """The engine without pipes; replies are decoded as the client does."""

    def __init__(self, scene: str = "FloorPlan201", **initialize: Any) -> None:
        self.engine = Engine(300, 300, draws=False)
        self.agent: dict[str, Any] = {}
        self.do("Reset", sceneName=f"{scene}_physics")
        self.do("Initialize", **{**BARS, **initialize})

    def do(self, action: str, **arguments: Any) -> dict[str, Any]:
        """The metadata after an action."""
        frames = self.engine.answer(json.dumps({"action": action, **arguments}).encode())
        field, body = frames[0]
        metadata = msgpack.unpackb(body)
        self.agent = metadata["agents"][0] if field == Field.METADATA else {**self.agent, **metadata}
        return self.agent

    def object(self, object_id: str) -> dict[str, Any]:
        return next(o for o in self.agent["objects"] if o["objectId"] == object_id)


@pytest.fixture(scope="session")
def engine() -> Callable[..., InProcess]:
    """`engine("FloorPlan1", gridSize=...)`: the engine on a scene, in this process and without images."""
    return InProcess


def pid_alive(pid: int) -> bool:
    """Whether a process runs; a zombie does not."""
    try:
        with open(f"/proc/{pid}/stat") as file:
            return file.read().rsplit(")", 1)[1].split()[0] != "Z"
    except FileNotFoundError:
        return False


@pytest.fixture(scope="session")
def alive() -> Callable[[int], bool]:
    return pid_alive


@pytest.fixture(scope="session")
def with_pipes() -> Callable[[Path], dict[str, str]]:
    """Makes the pipes of an engine process in a folder, and returns its environment."""

    def make(folder: Path) -> dict[str, str]:
        pipes = {f"AI2THOR_FIFO_{end.upper()}_PIPE_PATH": str(folder / f"{end}.pipe") for end in ("server", "client")}
        for path in pipes.values():
            os.mkfifo(path)
        return {**os.environ, **pipes}

    return make


@pytest.fixture
def engine_environment(with_pipes: Callable[[Path], dict[str, str]], tmp_path: Path) -> dict[str, str]:
    """Environment of an engine process whose pipes are in the test's own directory."""
    return with_pipes(tmp_path)
