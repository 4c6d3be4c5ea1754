"""All kernels are compiled before a client waits for an image."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from ovman_engine import kernels

LATER = """
import json, pathlib, sys
from ovman_engine import kernels
from ovman_engine.engine import Engine

def compiled():
    return {p.name for p in pathlib.Path(sys.argv[1]).rglob("*.nbc")}

assert not kernels.ready()
kernels.compile_all()
assert kernels.ready()
before = compiled()
engine = Engine(200, 150)
for scene in ("FloorPlan1", "FloorPlan305", "FloorPlan410", "FloorPlan214"):
    for action in (
        {"action": "Reset", "sceneName": f"{scene}_physics"},
        {"action": "Initialize", "agentMode": "locobot", **dict.fromkeys(kernels.KINDS, True)},
        *({"action": "RotateRight", "degrees": 77},) * 3,
        {"action": "InitialRandomSpawn", "randomSeed": 3},
        {"action": "RandomizeMaterials"},
        {"action": "RandomizeLighting"},
        {"action": "ToggleMapView"},
    ):
        engine.answer(json.dumps(action).encode())
assert before, "nothing was compiled"
assert compiled() == before, compiled() - before
"""


def test_a_mark_says_that_all_is_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    assert not kernels.ready()
    kernels._mark().parent.mkdir()
    kernels._mark().touch()
    assert kernels.ready()
    monkeypatch.setattr(kernels, "_processor", lambda: "another processor")
    assert not kernels.ready(), "what one processor runs, another may not"


def test_of_two_engines_one_compiles_and_the_other_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kept"))
    other, compiled = threading.Thread(target=kernels.compile_once), []

    def compile_all() -> None:
        compiled.append(threading.current_thread())
        if threading.current_thread() is not other:
            other.start()
            other.join(timeout=0.2)
            assert other.is_alive()
        kernels._mark().touch()

    monkeypatch.setattr(kernels, "compile_all", compile_all)
    kernels.compile_once()
    other.join()
    assert compiled == [threading.main_thread()]


@pytest.mark.soak
def test_nothing_is_compiled_later(tmp_path: Path) -> None:
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path)}
    subprocess.run([sys.executable, "-c", LATER, str(tmp_path)], env=environment, check=True, timeout=500)
