"""Recorded tours: what is read of them, and what makes two of them the same."""

from __future__ import annotations

import copy
import json
from pathlib import Path

import numpy as np
import pytest

from ovman.perception.tour_files import digest, tour
from ovman.records.visit import FILES, RECORD, TourError, write_tour
from tests.tour_zips import change_picture, contents, picture, png, rewrite

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


def record(file: Path, visit: dict = VISIT) -> Path:
    rng, made = np.random.default_rng(0), {RECORD: json.dumps(visit).encode()}
    for number in range(2):
        made[f"{number:02d}_rgb.png"] = png(rng.integers(0, 256, (4, 6, 3), np.uint8))
        made[f"{number:02d}_depth.png"] = png(rng.integers(0, 9000, (4, 6)).astype(np.uint16))
        made[f"{number:02d}_ids.png"] = png(rng.integers(0, 9, (4, 6)).astype(np.uint16))
    write_tour(file, made)
    return file


def test_views_as_they_were_recorded(tmp_path):
    file = record(tmp_path / "v")
    views = list(tour(file, 60.0))
    assert [v.camera.yaw_deg for v in views] == [90.0, 180.0] and [v.camera.horizon_deg for v in views] == [0.0, 30.0]
    assert views[0].camera.position == (1.0, 1.576, 2.0) and views[0].camera.field_of_view_deg == 60.0
    millimetres = picture(file, "01_depth.png")
    assert views[1].depth == pytest.approx(millimetres / 1000.0, abs=1e-6)
    blue_first = picture(file, "01_rgb.png")
    assert np.array_equal(views[1].rgb[..., 0], blue_first[..., 2]) and views[1].rgb.dtype == np.uint8


def test_tours_that_look_the_same_are_the_same_whatever_else_is_known_of_them(tmp_path):
    other = copy.deepcopy(VISIT) | {"present": {}, "visit": "another"}
    one, two = record(tmp_path / "one"), record(tmp_path / "two", other)
    change_picture(two, "00_ids.png")
    assert digest(one, 90.0, "by") == digest(two, 90.0, "by")


@pytest.mark.parametrize("what", ["00_rgb.png", "01_rgb.png", "01_depth.png", "yaw", "height", "fewer", "lens", "eyes"])
def test_what_could_be_seen_otherwise_counts(tmp_path, what):
    file = record(tmp_path / "v")
    before = digest(file, 90.0, "by")
    visit = copy.deepcopy(VISIT)
    if what.endswith("png"):
        change_picture(file, what)
    elif what == "yaw":
        visit["views"][1]["pose"]["yaw_deg"] = 181.0
    elif what == "height":
        visit["views"][0]["camera"]["y"] = 0.9
    elif what == "fewer":
        visit["views"].pop()
    rewrite(file, {RECORD: json.dumps(visit).encode()})
    assert digest(file, 60.0 if what == "lens" else 90.0, "others" if what == "eyes" else "by") != before


@pytest.mark.parametrize("says", ["lacks", "is not what was recorded"])
@pytest.mark.parametrize("name", ["visit.json", "01_rgb.png", "00_depth.png", FILES])
def test_a_file_that_is_lost_or_changed_is_named_in_one_line(tmp_path, name, says):
    file = record(tmp_path / "v")
    content = bytearray(contents(file)[name])
    content[-20] ^= 1
    if says == "lacks":
        rewrite(file, {name: None}, sealed=False)
    else:
        rewrite(file, {name: bytes(content[:40] if name == FILES else content)}, sealed=False)
        says = "torn" if name == FILES else says
    for read in (lambda: list(tour(file, 90.0)), lambda: digest(file, 90.0, "by")):
        with pytest.raises(TourError, match=f"{says}.*; record it again: ") as caught:
            read()
        assert str(caught.value).startswith(f"{file}: ") and "\n" not in str(caught.value)
