"""The constants of the baselines are defaults, with the values that the release was made with."""

from __future__ import annotations

import hashlib
import json

import yaml

from ovman.settings.config import load_files
from tests.arms import CONFIG, ROOT

SECTIONS = ("cow", "dualmap", "dynamem", "joint", "locobot", "react")
RELEASED = "2453e6051de0fae5797c94c0ccd23c8a15f9a7ddd5a9c10c24f9c914977a49cb"
"""SHA-256 of these sections in the release, sorted JSON."""


def _constants(settings):
    return {name: value for name, value in settings.constants().items() if name.split(".")[0] in SECTIONS}


def test_the_defaults_are_the_values_of_the_release():
    assert not set(SECTIONS) & set(yaml.safe_load((ROOT / "config.yaml").read_text()))
    unread = {"dualmap.local_map.life.waiting": 5}  # of the release, where no code read it
    found = _constants(CONFIG) | unread
    assert hashlib.sha256(json.dumps(found, sort_keys=True).encode()).hexdigest() == RELEASED, found


def test_a_file_overrides_single_constants(tmp_path):
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text("{cow: {stop_voxels: 4.0}, dualmap: {local_map: {life: {window: 7}}}}")
    expected = _constants(CONFIG) | {"cow.stop_voxels": 4.0, "dualmap.local_map.life.window": 7}
    assert _constants(load_files([ROOT / "config.yaml", overlay])) == expected
