"""All kernels are compiled before a client waits for an image."""

from __future__ import annotations

import threading
from pathlib import Path

import pytest

from ovman_engine import kernels


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
