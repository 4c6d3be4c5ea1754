"""Recorded tours as an agent is given them."""

from __future__ import annotations

import json

import numpy as np
import pytest

from ovman.evaluation.recorded_tours import digest_tour, load_visit
from ovman.records.visit import RECORD, write_tour
from tests.episodes import released
from tests.tour_zips import png, rewrite

FOV_DEG = 90.0
REACHABLE = np.zeros((1, 2))
CHANGED = [one.to_json() for one in released()[0].alterations("second")]


def tour(file, shade: int = 0, alterations=(), x: float = 1.0):
    """Three views, each of one colour, and a recording that says more than an agent may know."""
    made = {}
    for view in range(3):
        rgb = np.full((4, 6, 3), (200, 10 * view, shade), np.uint8)
        made[f"{view:02d}_rgb.png"] = png(rgb[..., ::-1])
        made[f"{view:02d}_depth.png"] = png(np.full((4, 6), 1500 + view, np.uint16))
        made[f"{view:02d}_ids.png"] = png(np.full((4, 6), len(alterations), np.uint16))
    camera, nothing = {"x": x, "y": 1.6, "z": 2.0}, {"instances": [], "seen": {}, "moved": {}}
    poses = [{"x": x, "z": 2.0, "yaw_deg": 90.0 * view, "horizon_deg": 0.0} for view in range(3)]
    record = {
        "schema": "ovman-visit/2",
        "scene": "FloorPlan1",
        "visit": file.name,
        "placed": {},
        "present": {},
        "movers": [],
    }
    record |= {"alterations": alterations, "views": [{"pose": pose, "camera": camera, **nothing} for pose in poses]}
    write_tour(file, made | {RECORD: json.dumps(record).encode()})
    return file


def test_frames_are_as_recorded_and_read_when_looked_at(tmp_path):
    file = tour(tmp_path / "tour")
    visit = load_visit(file, FOV_DEG, REACHABLE)
    rewrite(file, {"00_rgb.png": None}, sealed=False)
    assert len(visit.observations) == 3
    last = visit.observations[2]
    assert last.rgb.shape == (4, 6, 3) and last.rgb.dtype == np.uint8 and (last.rgb == (200, 20, 0)).all()
    assert last.depth.dtype == np.float32 and last.depth == pytest.approx(1.502)
    assert (last.pose.x, last.pose.y, last.pose.z, last.pose.yaw_deg) == (1.0, 1.6, 2.0, 180.0)
    assert last.field_of_view_deg == FOV_DEG and last.positions is None
    assert len(visit.observations[1:]) == 2 and (visit.observations[-1].rgb == last.rgb).all()
    with pytest.raises(IndexError):
        visit.observations[3]
    first = visit.observations[0]
    assert first.depth == pytest.approx(1.5)
    with pytest.raises(ValueError, match="00_rgb.png"):
        _ = first.rgb


def test_content_is_what_the_tour_shows(tmp_path):
    one = digest_tour(tour(tmp_path / "untouched"), FOV_DEG)
    same = digest_tour(tour(tmp_path / "displace-Chair", alterations=CHANGED), FOV_DEG)
    assert same == one
    others = [
        digest_tour(tour(tmp_path / "b", shade=1), FOV_DEG),
        digest_tour(tour(tmp_path / "c", x=1.1), FOV_DEG),
        digest_tour(tmp_path / "untouched", 80.0),
    ]
    assert len({one, *others}) == 4


def test_nothing_says_what_was_changed(tmp_path):
    visit = load_visit(tour(tmp_path / "displace-Chair", alterations=CHANGED), FOV_DEG, REACHABLE)
    public = {name for name in dir(visit.observations) if not name.startswith("_")}
    assert public == {"content", "count", "index"} and "Chair" not in repr(visit)
