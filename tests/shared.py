"""Things that several tests need and none changes: the first process that asks makes them for all processes of `make test`."""

from __future__ import annotations

import fcntl
import os
from collections.abc import Callable
from pathlib import Path

import pytest


def folder(factory: pytest.TempPathFactory) -> Path:
    """Return a folder that all processes of this session of pytest share."""
    own = factory.getbasetemp()
    found = (own.parent if "PYTEST_XDIST_WORKER" in os.environ else own) / "shared"
    found.mkdir(exist_ok=True)
    return found


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], None]) -> Path:
    """Return the path that `make` has filled, in this process or in another. A failure is not tried again."""
    place = folder(factory) / name
    said = place.with_name(f"{name}.said")
    with place.with_name(f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not said.exists():
            try:
                make(place)
            except BaseException as error:
                said.write_text(f"{type(error).__name__}: {error}")
                raise
            said.touch()
    assert not said.read_text(), f"{name} could not be made: {said.read_text()}"
    return place
