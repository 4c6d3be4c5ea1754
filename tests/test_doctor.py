"""`ovman doctor`: what it says where all is well, and where it is not."""

from __future__ import annotations

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from ovman import cli
from ovman.doctor import checks
from ovman.doctor.checks import Finding, State
from ovman.settings.settings_files import read_merged, with_parts
from ovman.shipped import HOME
from ovman.sim import unity
from tests.sim import unity_build


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


def test_the_engine_draws_here(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "ALWAYS", tuple(check for check in checks.ALWAYS if check is not checks.check_perception))
    assert cli.main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    frame = next(line for line in lines if "engine frame" in line)
    assert frame.startswith("ok") and "300 x 300 RGB, depth and ids" in frame
    assert not any(line.startswith("NO") for line in lines)


def test_the_first_line_says_that_kernels_are_compiled(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(checks, "ALWAYS", (checks.check_python,))
    assert cli.main(["doctor"]) == 0
    assert len(capsys.readouterr().out.splitlines()) == 1
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "empty"))
    assert cli.main(["doctor"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert "compiling" in first and "once" in first and second.startswith("ok")


def test_without_vulkan_unity_is_not_tried(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    monkeypatch.setattr(checks, "ALWAYS", (checks.check_python,))
    assert cli.main(["doctor", "--thor"]) == 1
    out = capsys.readouterr().out
    assert "Vulkan's library is not installed\n" in out and "apt install libvulkan1 vulkan-tools" in out
    assert out.count("not tried: vulkan first") == 2


def test_vulkan_names_its_devices(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    unity_build.machine(monkeypatch, tmp_path / "machine")
    assert checks.check_vulkan() == Finding("vulkan", State.WELL, "Some card")
    program(tmp_path / "machine" / "programs", "vulkaninfo", 'echo "no driver" >&2; exit 1')
    assert checks.check_vulkan().state is State.ILL and "no driver" in checks.check_vulkan().says
    (tmp_path / "machine" / "programs" / "vulkaninfo").unlink()
    monkeypatch.setenv("PATH", str(tmp_path / "machine" / "programs"))
    found = checks.check_vulkan()
    assert found.state is State.ABSENT and "vulkan-tools" in found.remedy


def test_unity_draws_where_it_can(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """On a machine on which the engine plays Unity."""
    home = unity_build.machine(monkeypatch, tmp_path / "machine")
    monkeypatch.setattr(checks, "ALWAYS", (checks.check_client,))
    assert cli.main(["doctor", "--thor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["ok"] * 4
    assert "Some card" in lines[1] and f"{home}/.ai2thor/releases/thor-CloudRendering-" in lines[2] and " MB" in lines[2]
    assert "300 x 300 RGB, depth and ids" in lines[3]


@pytest.mark.parametrize(("does", "says"), [("exit 3", "ended while it was being started"), ("sleep 60", "no frame within 1 s")])
def test_a_unity_that_does_not_draw_is_ended(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, does: str, says: str) -> None:
    home = unity_build.machine(monkeypatch, tmp_path / "machine")
    unity_build.build(home, f"exec /bin/sh -c '{does}'")
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "thor", 1.0 if "within" in says else 300.0)
    before = time.monotonic()
    found = checks.check_unity_frame()
    assert found.state is State.ILL and says in found.says and "Player.log" in found.remedy
    assert time.monotonic() - before < 200


def test_a_build_that_cannot_be_had_is_a_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(unity, "fetch", lambda: (_ for _ in ()).throw(unity.Missing("its build cannot be had", "fetch it")))
    assert checks.check_unity_build() == Finding("unity build", State.ILL, "its build cannot be had", "fetch it")


def test_the_stage_says_the_first_thing_that_is_missing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    with pytest.raises(unity.Missing, match="^benchmark.backend is thor, but Vulkan's library is not installed; sudo apt"):
        checks.check_simulator(tmp_path / "simulator.txt")
    assert not (tmp_path / "simulator.txt").exists()
    monkeypatch.undo()
    unity_build.machine(monkeypatch, tmp_path / "machine")
    checks.check_simulator(tmp_path / "simulator.txt")
    assert (tmp_path / "simulator.txt").read_text().count("ok ") == 3


def test_a_driver_that_fails_is_told_in_its_own_words(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    program(tmp_path, "nvidia-smi", "echo 'driver mismatch'; exit 9")
    monkeypatch.setenv("PATH", f"{tmp_path}:{os.environ['PATH']}")
    assert checks.check_gpu() == Finding("gpu", State.ABSENT, "nvidia-smi: driver mismatch", "reload the driver")
    program(tmp_path, "nvidia-smi", "echo 'GPU 0: Some card (UUID: GPU-1)'")
    assert checks.check_gpu() == Finding("gpu", State.WELL, "GPU 0: Some card")


def test_an_engine_that_cannot_be_imported_is_noticed_before_the_client_waits_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    (tmp_path / "ovman_engine").mkdir()
    (tmp_path / "ovman_engine" / "__init__.py").write_text("raise ImportError('another package of this name')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    found = checks.check_engine_process()
    assert found.state is State.ILL and "another package" in found.says and "install" in found.remedy


def test_networks_that_are_not_there_are_told_with_the_remedy(tmp_path: Path) -> None:
    settings = read_merged(with_parts(HOME / "config.yaml"))
    settings["perception"]["detector"]["weights"] = str(tmp_path / "none.safetensors")
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(settings, sort_keys=False))
    found = checks.check_perception(tmp_path / "config.yaml")
    assert (
        found.state is State.ILL
        and found.says.startswith("perception.detector.weights: the file ")
        and found.says.endswith("is missing")
    )
    assert "make models" in found.remedy and "\n" not in found.says + found.remedy
    assert checks.check_perception(tmp_path / "absent.yaml").state is State.ABSENT


@pytest.mark.networks
def test_both_networks_see_a_picture(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "NETWORKS_LIMIT_S", 500.0)
    from safetensors.torch import save_file

    from ovman.perception import pytorch

    sizes = {
        "embed_dim": 16,
        "vision_cfg": {"image_size": 32, "layers": 1, "width": 64, "patch_size": 16},
        "text_cfg": {"context_length": 16, "vocab_size": 49408, "width": 64, "heads": 1, "layers": 1},
    }
    (tmp_path / "encoder.json").write_text(json.dumps(sizes))
    network = pytorch.empty_detector("yolov8n-seg")
    save_file(network.state_dict(), tmp_path / "detector.safetensors")
    network = pytorch.empty_towers(pytorch.read_architecture(str(tmp_path / "encoder.json")))
    save_file(network.state_dict(), tmp_path / "encoder.safetensors")
    settings = read_merged(with_parts(HOME / "config.yaml"))
    settings["perception"]["detector"] |= {"weights": str(tmp_path / "detector.safetensors"), "sha256": ""}
    settings["perception"]["encoder"] |= {
        "model": str(tmp_path / "encoder.json"), "weights": str(tmp_path / "encoder.safetensors"), "sha256": "",
    }  # fmt: skip
    (tmp_path / "config.yaml").write_text(yaml.safe_dump(settings, sort_keys=False))
    found = checks.check_perception(tmp_path / "config.yaml")
    assert found.state is State.WELL and "on cpu" in found.says and "ultralytics" in found.says


def test_networks_that_never_answer_are_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks, "NETWORKS_LIMIT_S", 0.05)
    found = checks.check_perception(HOME / "config.yaml")
    assert found.state is State.ILL and "within 0.05 s" in found.says


def test_a_simulator_that_never_answers_is_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "embedded", 0.3)
    before = time.monotonic()
    found = checks.check_frame("embedded", "engine frame", "mend it")
    assert found == Finding("engine frame", State.ILL, "no frame within 0.3 s", "mend it")
    assert time.monotonic() - before < 20


def test_a_probe_that_fails_says_why(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "other", 60.0)
    found = checks.check_frame("other", "frame", "mend it")
    assert found.state is State.ILL and "'other' is not one of embedded, thor" in found.says


def test_home_that_cannot_be_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(checks.os, "access", lambda path, mode: False)
    found = checks.check_client()
    assert found.state is State.ILL and "cannot be written" in found.says


def test_the_command_is_installed_with_the_package() -> None:
    done = subprocess.run([sys.executable, "-m", "ovman.cli", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("ovman ")
    wrong = subprocess.run([sys.executable, "-m", "ovman.cli", "docter"], capture_output=True, text=True, check=False)
    assert wrong.returncode == 2 and "doctor" in wrong.stderr
