"""What a command reads where nothing else is named."""

from __future__ import annotations

from ovman.shipped import EMBEDDED, HOME

CONFIG, DATA, LEADERBOARD = HOME / "config.yaml", HOME / EMBEDDED, HOME / "leaderboard"
"""The settings, the release, and everybody's entries."""
