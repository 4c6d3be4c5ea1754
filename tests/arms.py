"""The arms of config.yaml."""

from __future__ import annotations

from pathlib import Path

from ovman.agents.arms import Need, table
from ovman.config import load

ROOT = Path(__file__).parents[1]
CONFIG = load(ROOT / "config.yaml")
ARMS = table(CONFIG.arms)
BY_NAME = {arm.name: arm for arm in ARMS}
REFERENCE = tuple(arm for arm in ARMS if set(arm.needs) <= {Need.MAPS})
"""Those that answer from the reference agent's maps or from what is handed to them."""
