"""A forked engine draws what an engine of its own process draws, and lives as long."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path

import pytest

DRIVES = """
import hashlib, json, os, signal, sys, time
import ai2thor.controller
from ai2thor.controller import Controller
from ovman_engine import executable, forked, kernels

kernels.compile_once()
{warm}
def begin():
    return Controller(
        local_executable_path=executable(), server_timeout=None, scene="FloorPlan425", width=160, height=120,
        renderDepthImage=True, renderInstanceSegmentation=True,
    )

def seen(controller):
    events = [controller.last_event, controller.step("RotateRight"), controller.step("MoveAhead"), controller.reset("FloorPlan1")]
    found = hashlib.sha256()
    for event in events:
        found.update(event.frame.tobytes() + event.depth_frame.tobytes() + event.instance_segmentation_frame.tobytes())
        found.update(json.dumps(event.metadata["objects"], sort_keys=True).encode())
    return found.hexdigest()

def commands(process):
    return open(f"/proc/{{process}}/cmdline").read().replace(chr(0), " ")

controller = begin()
process = controller.server.unity_proc
said = {{"forked": commands(process.pid) == commands(os.getpid()), "running": process.poll(), "seen": [seen(controller)]}}
other = begin()
said["seen"].append(seen(other))
{end}
print(json.dumps(said))
"""
WARM = "forked.warm(ai2thor.controller); forked.warm(ai2thor.controller)"
STOPPED = """
controller.stop()
said["ended"] = process.wait(10)
other.server.unity_proc.send_signal(signal.SIGTERM)
said["terminated"] = other.server.unity_proc.wait(10)
other.server.unity_proc.kill()
"""


def drive(warm: str, end: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, "-c", DRIVES.format(warm=warm, end=end)], capture_output=True, text=True)


def test_a_forked_engine_draws_what_an_engine_of_its_own_draws():
    ran = [drive(warm, STOPPED) for warm in (WARM, "")]
    assert [one.returncode for one in ran] == [0, 0], [one.stderr for one in ran]
    forked, own = (json.loads(one.stdout.splitlines()[-1]) for one in ran)
    assert (forked.pop("forked"), own.pop("forked")) == (True, False)
    assert forked == own
    assert len(set(forked["seen"])) == 1 and forked["running"] is None and forked["terminated"] == -15


@pytest.mark.parametrize("kill", ["os._exit(0)", "os.kill(os.getpid(), signal.SIGKILL)"])
def test_forked_engines_end_with_the_process_that_drives_them(kill):
    told = f"print(json.dumps([one.server.unity_proc.pid for one in (controller, other)]), flush=True)\n{kill}"
    said = drive(WARM, told)
    for engine in json.loads(said.stdout.splitlines()[-1]):
        for _ in range(50):
            if not Path("/proc", str(engine)).exists():
                break
            time.sleep(0.1)
        else:
            raise AssertionError(f"engine {engine} is still there")


def test_an_engine_that_is_killed_is_noticed():
    said = drive(WARM, "process.kill()\ntry: controller.step('Pass')\nexcept Exception as e: said['error'] = type(e).__name__")
    assert said.returncode == 0, said.stderr
    found = json.loads(said.stdout.splitlines()[-1])
    assert "error" in found
