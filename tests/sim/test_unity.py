"""Differences of Unity from the engine, tested on the engine and on a build that the engine stands in for."""

from __future__ import annotations

import time
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.sim import controller, unity
from ovman.sim.embodiment import Embodiment
from ovman.sim.session import AgentPose, Session, SimulatorError
from tests.sim import unity_build

SCENE = "FloorPlan401"
BODY = Embodiment(120, 120, 90.0, 0.25, 30.0)
LOCOBOT = Embodiment(120, 120, 90.0, 0.25, 30.0, mode="locobot", instances=False)


def session(backend="embedded", body=BODY):
    return Session(SCENE, SimpleNamespace(benchmark=SimpleNamespace(backend=backend)), body)


@pytest.fixture(scope="module")
def engine():
    with session() as made:
        yield made


@pytest.fixture(scope="module")
def thor(tmp_path_factory):
    """The backend "thor", as far as it can be had without a GPU."""
    with pytest.MonkeyPatch.context() as patch:
        unity_build.machine(patch, tmp_path_factory.mktemp("machine"))
        with session("thor") as made:
            yield made


def test_depth_of_unity_is_corrected(engine, thor):
    """Unity's own is short by near / far. The engine's, here in Unity's place, is not, so its corrected one is too long."""
    seen = {}
    for made in (engine, thor):
        made.reset()
        made.teleport(AgentPose(made.pose.x, made.pose.z, 0.0, 60.0), image=True)
        seen[made] = made.depth
    np.testing.assert_allclose(seen[thor] * np.float32(19.9 / 20), seen[engine], rtol=1e-6)


def test_a_body_that_does_not_crouch_is_not_told_to_stand():
    with session(body=LOCOBOT) as made:
        made.reset()
        assert made._event.metadata["agent"]["isStanding"] is None
        pose = made.pose
        assert made.teleport(AgentPose(pose.x, pose.z, 90.0), image=True)
        assert made._event.instance_segmentation_frame is None and made.depth.shape == (120, 120)
        made.step("MoveAhead", allowed=True)
        moved = abs(made.pose.x - pose.x)
        assert moved == pytest.approx(0.25, abs=1e-6) or moved == 0, "without noise"


def test_error_codes_are_mistakes_and_an_empty_message_gets_words(engine):
    engine.reset()
    with pytest.raises(ValueError, match="missing the following arguments: objectId"):
        engine.step("DisableObject")
    with pytest.raises(SimulatorError, match="DisableObject: refused without a reason: .*Nothing") as refused:
        engine.step("DisableObject", objectId="Nothing|+00.00|+00.00|+00.00")
    assert engine._event.metadata["errorMessage"] == "" and SCENE in str(refused.value)


@pytest.fixture
def bare(tmp_path, monkeypatch):
    """A machine without anything."""
    monkeypatch.setenv("HOME", str(tmp_path))
    monkeypatch.delenv("CUDA_VISIBLE_DEVICES", raising=False)
    return tmp_path


@pytest.mark.parametrize(
    ("library", "script", "line"),
    [
        (None, "exit 1", r"^benchmark\.backend is thor, but Vulkan's library is not installed; sudo apt install libvulkan1"),
        ("libvulkan.so.1", "echo 'no driver' >&2; exit 1", r"Vulkan finds no device \(no driver\); install the GPU's own driver"),
        ("libvulkan.so.1", "echo", r"Vulkan finds no device \(vulkaninfo names none\)"),
        (
            "libvulkan.so.1",
            "echo ' deviceName = llvmpipe'; echo ' deviceType = PHYSICAL_DEVICE_TYPE_CPU'",
            r"without a GPU here \(llvmpipe\)",
        ),
        ("libvulkan.so.1", "exec sleep 60", r"vulkaninfo does not answer \(TimeoutExpired\)"),
    ],
)
def test_a_machine_without_a_gpu_is_told_in_a_line(bare, monkeypatch, library, script, line):
    monkeypatch.setattr(unity.ctypes.util, "find_library", lambda name: library)
    monkeypatch.setattr(unity, "VULKANINFO_LIMIT_S", 0.5 if "sleep" in script else 60.0)
    unity_build.program(bare / "programs", "vulkaninfo", script)
    monkeypatch.setenv("PATH", f"{bare / 'programs'}:/usr/bin:/bin")
    with pytest.raises(unity.Missing, match=line) as missing, session("thor") as made:
        made.reset()
    assert "\n" not in str(missing.value)


def test_a_chosen_gpu_needs_vulkaninfo_and_others_do_not(bare, monkeypatch):
    monkeypatch.setattr(unity.ctypes.util, "find_library", lambda name: "libvulkan.so.1")
    monkeypatch.setenv("PATH", str(bare))
    assert unity.find_gpus() is None
    monkeypatch.setenv("CUDA_VISIBLE_DEVICES", "0")
    with pytest.raises(unity.Missing, match="unset CUDA_VISIBLE_DEVICES"):
        unity.find_gpus()


def test_a_build_that_cannot_be_downloaded_is_a_line(bare, monkeypatch):
    monkeypatch.setenv("https_proxy", "http://127.0.0.1:9")
    monkeypatch.setenv("http_proxy", "http://127.0.0.1:9")
    with pytest.raises(unity.Missing, match=r"cannot be downloaded \(.*refused.*; see to it that .* can be reached") as missing:
        unity.fetch()
    assert "\n" not in str(missing.value)
    with pytest.raises(unity.Missing, match="not downloaded within 0.01 s"):
        unity.fetch(0.01)


@pytest.mark.parametrize(("does", "limit_s"), [("exit 1", 60.0), ("sleep 60", 0.5)], ids=["dies", "says nothing"])
def test_a_build_that_does_not_start_is_noticed(tmp_path, monkeypatch, does, limit_s):
    monkeypatch.setattr(controller, "START_LIMIT_S", limit_s)
    home = unity_build.machine(monkeypatch, tmp_path)
    unity_build.build(home, f"exec /bin/sh -c '{does}'")
    begun = time.monotonic()
    with pytest.raises(ConnectionError, match="while it was being started"):
        controller.start("thor", SCENE, BODY)
    assert time.monotonic() - begun < 30
