"""Recorded tours: what is read of them, and what makes two of them the same."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import cv2
import numpy as np
import pytest

from ovman.perception.tour_files import digest, tour
from ovman.records.visit import FILES, TourError, seal

VIEW = {"instances": [], "seen": {}, "moved": {}, "camera": {"x": 1.0, "y": 1.576, "z": 2.0}}
VISIT = {
    "schema": "ovman-visit/2",
    "scene": "FloorPlan1",
    "visit": "one",
    "alterations": [],
    "placed": {},
    "movers": [],
    "views": [
        VIEW | {"pose": {"x": 1.0, "z": 2.0, "yaw_deg": 90.0, "horizon_deg": 0.0}},
        VIEW | {"pose": {"x": 1.0, "z": 2.0, "yaw_deg": 180.0, "horizon_deg": 30.0}},
    ],
    "present": {"Chair|1": {"category": "Chair", "position": {"x": 0.0, "y": 0.5, "z": 2.0}}},
}


def record(directory: Path, visit: dict = VISIT) -> Path:
    rng = np.random.default_rng(0)
    directory.mkdir()
    (directory / "visit.json").write_text(json.dumps(visit))
    for number in range(2):
        cv2.imwrite(str(directory / f"{number:02d}_rgb.png"), rng.integers(0, 256, (4, 6, 3), np.uint8))
        cv2.imwrite(str(directory / f"{number:02d}_depth.png"), rng.integers(0, 9000, (4, 6)).astype(np.uint16))
        cv2.imwrite(str(directory / f"{number:02d}_ids.png"), rng.integers(0, 9, (4, 6)).astype(np.uint16))
    seal(directory)
    return directory


def change_picture(path: Path) -> None:
    """Record another picture."""
    picture = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
    picture[0, 0] = picture[0, 0] + 1
    cv2.imwrite(str(path), picture)
    seal(path.parent)


def test_views_as_they_were_recorded(tmp_path):
    directory = record(tmp_path / "v")
    views = list(tour(directory, 60.0))
    assert [v.camera.yaw_deg for v in views] == [90.0, 180.0] and [v.camera.horizon_deg for v in views] == [0.0, 30.0]
    assert views[0].camera.position == (1.0, 1.576, 2.0) and views[0].camera.field_of_view_deg == 60.0
    millimetres = cv2.imread(str(directory / "01_depth.png"), cv2.IMREAD_UNCHANGED)
    assert views[1].depth == pytest.approx(millimetres / 1000.0, abs=1e-6)
    blue_first = cv2.imread(str(directory / "01_rgb.png"))
    assert np.array_equal(views[1].rgb[..., 0], blue_first[..., 2]) and views[1].rgb.dtype == np.uint8


def test_tours_that_look_the_same_are_the_same_whatever_else_is_known_of_them(tmp_path):
    other = copy.deepcopy(VISIT) | {"present": {}, "visit": "another"}
    one, two = record(tmp_path / "one"), record(tmp_path / "two", other)
    change_picture(two / "00_ids.png")
    assert digest(one, 90.0, "by") == digest(two, 90.0, "by")


@pytest.mark.parametrize("what", ["00_rgb.png", "01_rgb.png", "01_depth.png", "yaw", "height", "fewer", "lens", "eyes"])
def test_what_could_be_seen_otherwise_counts(tmp_path, what):
    directory = record(tmp_path / "v")
    before = digest(directory, 90.0, "by")
    visit = copy.deepcopy(VISIT)
    if what.endswith("png"):
        change_picture(directory / what)
    elif what == "yaw":
        visit["views"][1]["pose"]["yaw_deg"] = 181.0
    elif what == "height":
        visit["views"][0]["camera"]["y"] = 0.9
    elif what == "fewer":
        visit["views"].pop()
    (directory / "visit.json").write_text(json.dumps(visit))
    seal(directory)
    assert digest(directory, 60.0 if what == "lens" else 90.0, "others" if what == "eyes" else "by") != before


@pytest.mark.parametrize("says", ["No such file or directory", "its content is not what was recorded"])
@pytest.mark.parametrize("name", ["visit.json", "01_rgb.png", "00_depth.png", FILES])
def test_a_file_that_is_lost_or_changed_is_named_in_one_line(tmp_path, name, says):
    directory = record(tmp_path / "v")
    content = bytearray((directory / name).read_bytes())
    content[-20] ^= 1
    (directory / name).unlink()
    if says.startswith("its content"):
        (directory / name).write_bytes(content[:40] if name == FILES else content)
        says = "torn" if name == FILES else says
    for read in (lambda: list(tour(directory, 90.0)), lambda: digest(directory, 90.0, "by")):
        with pytest.raises(TourError, match=f"{says}.*; record it again: ") as caught:
            read()
        assert str(caught.value).startswith(str(directory / name)) and "\n" not in str(caught.value)
