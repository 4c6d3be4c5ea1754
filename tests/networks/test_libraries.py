"""Importing and running the network libraries asks nothing of the network, installs nothing and writes to our own folder only."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.networks
ROOT = Path(__file__).parents[2]

PROBE = """
import json, os, sys

seen = {"asked": [], "written": []}


def hook(event, arguments):
    if event.startswith(("socket.getaddrinfo", "socket.gethostby", "socket.connect", "socket.sendto", "urllib.")):
        seen["asked"].append([event, repr(arguments)])
    elif event == "subprocess.Popen":
        seen["asked"] += [[event, a] for a in map(str, arguments[1]) if a in ("pip", "uv", "curl", "wget", "git")]
    elif event == "open" and isinstance(arguments[0], str) and arguments[2] & (os.O_WRONLY | os.O_RDWR):
        seen["written"].append(arguments[0])
    elif event in ("os.mkdir", "os.rename"):
        seen["written"].append(str(arguments[0]))


sys.addaudithook(hook)
from pathlib import Path

import numpy as np

from ovman.perception import networks, pytorch

network = pytorch.load_detector(Path(sys.argv[1]), "yolov8n-seg")
(found,) = networks.loaded_detector(network, 64, 0.25).detect([np.zeros((64, 64, 3), np.uint8)])
assert found.masks.shape[1:] == (64, 64)
import open_clip

assert open_clip.get_tokenizer("ViT-B-32")(["a chair"]).shape == (1, 77)
print(json.dumps(seen))
"""


def test_nothing_is_asked_for_and_nothing_of_the_users_is_written(tmp_path: Path) -> None:
    home, place = tmp_path / "home", tmp_path / "place"
    home.mkdir()
    place.mkdir()
    kept = {k: v for k, v in os.environ.items() if not k.startswith(("YOLO_", "HF_", "XDG_", "PYTEST"))}
    # Not in offline mode because nothing can be reached: what is asked for is seen before it fails.
    environment = kept | {"HOME": str(home), "PYTHONPATH": str(ROOT), "PYTHONDONTWRITEBYTECODE": "1"}
    done = subprocess.run(
        [sys.executable, "-c", PROBE, str(ROOT / "models" / "detector.safetensors")],
        cwd=place,
        env=environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    seen = json.loads(done.stdout.splitlines()[-1])
    assert seen["asked"] == []
    ours = home / ".cache" / "ovman"
    assert any(Path(path).is_relative_to(ours) for path in seen["written"]), "the probe sees what is written"
    assert [p for p in home.rglob("*") if p.is_file() and not p.is_relative_to(ours)] == []
    assert list(place.iterdir()) == []
    assert all(
        Path(path) == home / ".cache" or not (Path(path).is_relative_to(home) and not Path(path).is_relative_to(ours))
        for path in seen["written"]
    )
