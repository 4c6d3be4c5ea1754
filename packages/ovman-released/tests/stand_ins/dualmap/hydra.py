"""Stands in for Hydra: settings of one yaml, overridden as on its command line."""

from __future__ import annotations

from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace

import yaml

_directory: list[Path] = []


@contextmanager
def initialize_config_dir(config_dir, version_base="1.1"):
    assert version_base is None
    assert Path(config_dir).is_absolute()
    _directory.append(Path(config_dir))
    yield
    _directory.pop()


def compose(config_name, overrides=()):
    settings = yaml.safe_load((_directory[-1] / f"{config_name}.yaml").read_text())
    for text in overrides:
        name, _, value = text.partition("=")
        assert name in settings, f"{name} is no setting"
        settings[name] = yaml.safe_load(value.replace("\\'", "''"))
    return SimpleNamespace(**settings | {"yolo": SimpleNamespace(**settings["yolo"])})
