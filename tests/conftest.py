"""Share out tests among processes (`make test` runs two) by file, because fixtures last as long as a module.

What takes long to make and is of use to several files, such as the finished world of the workflow's tests, is made by the first
process that needs it (tests/shared.py).

Examples are drawn in the same way every time, so that a change fails for what it does; `pytest --hypothesis-profile default`
draws others, and more.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Generator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from hypothesis import settings

from ovman.sim import controller
from tests import forked_engine, shared

if TYPE_CHECKING:
    from ai2thor.controller import Controller

settings.register_profile("same", derandomize=True, deadline=None, max_examples=30)
settings.load_profile("same")

NETWORKS = Path(__file__).parent / "networks"

FIRST = (
    *("tests/workflow/test_reruns.py", "tests/entry/", "tests/workflow/", "tests/golden/"),
    *("tests/gym/", "tests/generation/", "tests/report/"),
)
"""The longest files, in order. One process makes the world of the workflow while the other runs files that do not need it."""


@pytest.fixture(scope="session", autouse=True)
def _forked_engines() -> Generator[None, None, None]:
    """Fork the engines of this process instead of starting them, which takes a second each.

    What they need is loaded with the first. The engine's own tests start theirs.
    """
    found = controller.controller_class

    def forking() -> type[Controller]:
        made = found()
        forked_engine.warm(sys.modules[made.__module__])
        return made

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(controller, "controller_class", forking)
        yield


@pytest.fixture(scope="session")
def tours(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of recorded tours. Processes share it, so each tour is recorded once."""
    return shared.folder(tmp_path_factory) / "tours"


def pytest_ignore_collect(collection_path: Path, config: pytest.Config) -> bool | None:
    """Leave out tests/networks where its marker is deselected: its files import PyTorch, which need not be installed."""
    left_out = collection_path == NETWORKS and "not networks" in config.option.markexpr
    return True if left_out else None


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Collect no garbage while tests are collected: imported modules stay, and looking through them takes a second each time."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        # A twelfth of a process's time went into looking through all of its objects, which rarely are garbage.
        gc.set_threshold(10_000, 20, 100)
        gc.enable()


@pytest.hookimpl(tryfirst=True)
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Run the longest files first, so that no process is left with one of them at the end."""

    def place(item: pytest.Item) -> int:
        return next((number for number, folder in enumerate(FIRST) if item.nodeid.startswith(folder)), len(FIRST))

    items.sort(key=place)
