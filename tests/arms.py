"""The arms of config.yaml."""

from __future__ import annotations

from pathlib import Path

import yaml

from ovman.settings import Arm, Need, arms_of
from ovman.settings.config import load
from ovman.settings.settings_files import read_merged, with_parts

ROOT = Path(__file__).parents[1]
CONFIG = load(ROOT / "config.yaml")
ARMS = arms_of(CONFIG.arms)
BY_NAME = {arm.name: arm for arm in ARMS}
REFERENCE = tuple(arm for arm in ARMS if set(arm.needs) <= {Need.MAPS})
"""Those that answer from the reference agent's maps or from what is handed to them."""


def with_overlay(name: str) -> dict[str, Arm]:
    """The arms by their names where an overlay of the repository is put on top of config.yaml."""
    config = read_merged(with_parts(ROOT / "config.yaml"))
    overlay = yaml.safe_load((ROOT / "overlays" / f"{name}.yaml").read_text())
    config["arms"] |= {arm: config["arms"].get(arm, {}) | entry for arm, entry in overlay["arms"].items()}
    return {arm.name: arm for arm in arms_of(load(config).arms)}
