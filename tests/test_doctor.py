"""`ovman doctor`: what it says where all is well, and where it is not."""

from __future__ import annotations

import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from ovman import cli
from ovman.doctor import checks
from ovman.doctor.checks import Finding, State


@pytest.fixture(autouse=True)
def home(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A home of the test's own: the client writes its log there."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    return tmp_path


def program(folder: Path, name: str, script: str) -> None:
    """A program `name` that stands first in PATH."""
    (folder / name).write_text(f"#!/bin/sh\n{script}\n")
    (folder / name).chmod(0o755)


def test_the_engine_draws_here(capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    frame = next(line for line in lines if "engine frame" in line)
    assert frame.startswith("ok") and "300 x 300 RGB, depth and ids" in frame
    assert not any(line.startswith("NO") for line in lines)


def test_without_vulkan_unity_is_not_tried(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PATH", "")
    monkeypatch.setattr(checks, "HERE", (checks.python,))
    assert cli.main(["doctor", "--thor"]) == 1
    out = capsys.readouterr().out
    assert "vulkaninfo is not installed\n" in out and "apt install vulkan-tools" in out
    assert "not tried: vulkan first" in out


def test_vulkan_names_its_devices(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, "vulkaninfo", 'echo "  deviceName = Some card"')
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert checks.vulkan() == Finding("vulkan", State.WELL, "Some card")
    program(tmp_path, "vulkaninfo", 'echo "no driver" >&2; exit 1')
    assert checks.vulkan().state is State.ILL and checks.vulkan().says == "no driver"


def test_a_driver_that_fails_is_told_in_its_own_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, "nvidia-smi", "echo 'driver mismatch'; exit 9")
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert checks.gpu() == Finding("gpu", State.ABSENT, "nvidia-smi: driver mismatch", "reload the driver")
    program(tmp_path, "nvidia-smi", "echo 'GPU 0: Some card (UUID: GPU-1)'")
    assert checks.gpu() == Finding("gpu", State.WELL, "GPU 0: Some card")


def test_visible_devices_without_vulkaninfo_are_a_trap(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "0")
    monkeypatch.setenv("PATH", "")
    found = checks.client()
    assert found.state is State.ABSENT and "CUDA_VISIBLE_DEVICES" in found.remedy


def test_an_engine_that_cannot_be_imported_is_noticed_before_the_client_waits_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ovman").mkdir()
    (tmp_path / "ovman" / "__init__.py").write_text("raise ImportError('another package of this name')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    found = checks.engine_process()
    assert found.state is State.ILL and "another package" in found.says and "install" in found.remedy


def test_a_simulator_that_never_answers_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "embedded", 0.3)
    before = time.monotonic()
    found = checks.frame("embedded", "engine frame", "mend it")
    assert found == Finding("engine frame", State.ILL, "no frame within 0.3 s", "mend it")
    assert time.monotonic() - before < 20


def test_a_probe_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "other", 60.0)
    found = checks.frame("other", "frame", "mend it")
    assert found.state is State.ILL and "'other' is not one of embedded, thor" in found.says


def test_home_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks.os, "access", lambda path, mode: False)
    found = checks.client()
    assert found.state is State.ILL and "cannot be written" in found.says


def test_the_command_is_installed_with_the_package() -> None:
    done = subprocess.run([sys.executable, "-m", "ovman.cli", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("ovman ")
    wrong = subprocess.run([sys.executable, "-m", "ovman.cli", "docter"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2 and "doctor" in wrong.stderr
