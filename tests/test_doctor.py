"""`ovman doctor`: its results where all is well, and where something is missing or does not answer."""

from __future__ import annotations

import time
from functools import partial

import pytest
import yaml

from ovman import cli
from ovman.doctor import checks
from ovman.doctor.checks import CHECKS, State, check_frame, check_perception, run_check
from ovman.settings.settings_files import read_merged, with_parts
from ovman.shipped import HOME
from ovman.sim import unity
from tests.sim import unity_build


@pytest.fixture(autouse=True)
def home(tmp_path, monkeypatch):
    """A home of the test's own: the client writes its log there."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    return tmp_path


@pytest.fixture
def only(monkeypatch):
    """Leaves the named checks."""
    return lambda *names: monkeypatch.setattr(checks, "CHECKS", {name: CHECKS[name] for name in names})


def test_engine_and_networks_work_here(capsys, only):
    only("python", "ai2thor", "engine process", "engine frame", "perception", "isolation")
    assert cli.main(["doctor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["ok"] * 6 and "300 x 300 RGB, depth and ids" in lines[3]


def test_without_vulkan_unity_is_not_tried(tmp_path, capsys, monkeypatch, only):
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    only("python", *checks.UNITY)
    assert cli.main(["doctor", "--thor"]) == 1
    out = capsys.readouterr().out
    assert "Vulkan's library is not installed\n" in out and "apt install libvulkan1 vulkan-tools" in out
    assert out.count("not tried: vulkan first") == 2
    with pytest.raises(unity.Missing, match="^benchmark.backend is thor, but Vulkan's library is not installed; sudo apt"):
        checks.check_simulator(tmp_path / "simulator.txt")
    assert not (tmp_path / "simulator.txt").exists()


def test_with_a_gpu_and_the_build_unity_is_tried(tmp_path, capsys, monkeypatch, only):
    home = unity_build.machine(monkeypatch, tmp_path / "machine")
    only(*checks.UNITY)
    monkeypatch.setitem(checks.CHECKS, "unity frame", lambda: "draws")
    assert cli.main(["doctor", "--thor"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in lines] == ["ok"] * 3
    assert "Some card" in lines[0] and f"{home}/.ai2thor/releases/thor-CloudRendering-" in lines[1]
    checks.check_simulator(tmp_path / "simulator.txt")
    assert (tmp_path / "simulator.txt").read_text().count("ok ") == 3
    (tmp_path / "machine" / "programs" / "vulkaninfo").unlink()
    monkeypatch.setenv("PATH", str(tmp_path / "machine" / "programs"))
    found = run_check("vulkan")
    assert found.state is State.ABSENT and "vulkan-tools" in found.remedy


def test_an_engine_that_cannot_be_imported_is_noticed_before_the_client_waits_for_it(tmp_path, monkeypatch):
    (tmp_path / "ovman_engine").mkdir()
    (tmp_path / "ovman_engine" / "__init__.py").write_text("raise ImportError('another package of this name')")
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setenv("PYTHONSAFEPATH", "1")
    found = run_check("engine process")
    assert found.state is State.ILL and "another package" in found.says and "install" in found.remedy


def test_networks_that_are_missing_are_named_with_the_remedy(tmp_path, monkeypatch):
    settings, path = read_merged(with_parts(HOME / "config.yaml")), tmp_path / "config.yaml"
    settings["perception"]["detector"]["weights"] = str(tmp_path / "none.safetensors")
    path.write_text(yaml.safe_dump(settings, sort_keys=False))
    monkeypatch.setitem(CHECKS, "perception", partial(check_perception, path))
    found = run_check("perception")
    assert found.state is State.ILL and found.says.startswith("perception.detector.weights: the file ")
    assert found.says.endswith("is missing") and "make models" in found.remedy and "\n" not in found.remedy


def test_what_never_answers_is_ended(monkeypatch):
    monkeypatch.setattr(checks, "NETWORKS_LIMIT_S", 0.05)
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "embedded", 0.3)
    before = time.monotonic()
    assert "within 0.05 s" in run_check("perception").says
    assert run_check("engine frame").says == "no frame within 0.3 s"
    assert time.monotonic() - before < 20


def test_a_probe_that_fails_says_why(monkeypatch):
    monkeypatch.setitem(checks.FRAME_LIMIT_S, "other", 60.0)
    monkeypatch.setitem(CHECKS, "frame", partial(check_frame, "other", "mend it"))
    found = run_check("frame")
    assert "'other' is not one of embedded, thor" in found.says and found.remedy == "mend it"


def test_a_home_that_cannot_be_written(monkeypatch):
    monkeypatch.setattr(checks.os, "access", lambda path, mode: False)
    assert "cannot be written" in run_check("ai2thor").says
