"""The settings of config.yaml with the overlays of this package on top, as Snakemake merges them."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import yaml

from ovman.settings import Settings
from ovman.settings.config import load
from ovman.settings.settings_files import read_merged, with_parts

PACKAGE = Path(__file__).resolve().parents[1]
ROOT = PACKAGE.parents[1]


def merged(below: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """Two trees of settings as one; sections are merged, other values of `above` win."""
    both = {
        name: merged(below[name], value) if isinstance(value, Mapping) and isinstance(below.get(name), Mapping) else value
        for name, value in above.items()
    }
    return {**below, **both}


def tree(*systems: str, **sections: Any) -> dict[str, Any]:
    """What is loaded for the overlays of these systems ("cow", "dualmap"), with further sections on top."""
    made: dict[str, Any] = read_merged(with_parts(ROOT / "config.yaml"))
    for system in systems:
        made = merged(made, yaml.safe_load((PACKAGE / f"{system}.yaml").read_text()))
    return merged(made, sections)


def settings_of(*systems: str, **sections: Any) -> Settings:
    """The settings for the overlays of these systems, with further sections on top."""
    return load(tree(*systems, **sections))
