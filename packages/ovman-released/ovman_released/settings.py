"""The sections of this package in a job's settings, typed."""

from __future__ import annotations

from ovman.settings import Settings
from ovman.settings.plugins import section
from ovman_released.plugin import COW, DUALMAP, ReleasedCow, ReleasedDualmap


def released_cow(settings: Settings) -> ReleasedCow:
    """Section `released_cow`. Raises TypeError where the plug-in is not registered."""
    return section(settings, COW, ReleasedCow)


def released_dualmap(settings: Settings) -> ReleasedDualmap:
    """Section `released_dualmap`. Raises TypeError where the plug-in is not registered."""
    return section(settings, DUALMAP, ReleasedDualmap)
