"""What a command reads where nothing else is named."""

from __future__ import annotations

from ovman.shipped import EMBEDDED, HOME

CONFIG, DATA = HOME / "config.yaml", HOME / EMBEDDED
"""The settings, and the release."""
