"""The guard against frames in which DualMap's detector finds nothing, on a detector with its fault."""

from __future__ import annotations

from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path
from types import ModuleType, SimpleNamespace

import numpy as np
import pytest

from ovman_released.dualmap_process import guard

NOTHING, SOMETHING = np.zeros((6, 8, 3), np.uint8), np.zeros((6, 8, 3), np.uint8)
SOMETHING[2:4, 3:6, 0] = 10


@pytest.fixture
def module() -> ModuleType:
    """A detector of its own for every test: guarding changes its classes."""
    spec = spec_from_file_location("a_detector", Path(__file__).parent / "stand_ins" / "dualmap" / "utils" / "object_detector.py")
    made = module_from_spec(spec)
    spec.loader.exec_module(made)
    return made


def seen(module: ModuleType, *frames: np.ndarray) -> list[int]:
    """How many objects the detector sees in each frame."""
    detector = module.Detector(SimpleNamespace(scene_id=""))
    return [len(detector.process_detections(frame)) for frame in frames]


def test_without_it_an_empty_first_frame_is_the_end(module):
    with pytest.raises(AttributeError, match="curr_detections"):
        seen(module, NOTHING)


@pytest.mark.parametrize("mode", [guard.FIRST_ONLY, guard.EVERY_FRAME])
def test_an_empty_first_frame_shows_nothing(module, mode):
    guard.apply(module, mode)
    assert seen(module, NOTHING, NOTHING, SOMETHING) == [0, 0, 1]


def test_a_later_empty_frame_shows_the_frame_before_as_released(module):
    assert seen(module, SOMETHING, NOTHING) == [1, 1]
    guard.apply(module, guard.FIRST_ONLY)
    assert seen(module, SOMETHING, NOTHING) == [1, 1]


def test_and_nothing_where_every_frame_is_guarded(module):
    guard.apply(module, guard.EVERY_FRAME)
    assert seen(module, SOMETHING, NOTHING, SOMETHING) == [1, 0, 1]


def test_there_are_two_modes(module):
    with pytest.raises(ValueError, match="must be first_only or every_frame"):
        guard.apply(module, "sometimes")
