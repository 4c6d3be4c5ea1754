"""Detected masks against true instances: matching, place, retrieval and the scores of every group."""

from __future__ import annotations

import csv
import json
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.analysis import perception
from ovman.analysis.backprojection import DETECTED, TRUE, box_distance_m, centre_distance_m, locate_masks
from ovman.analysis.instances import TrueObject, TrueScene, match_masks, read_scenes
from ovman.analysis.perception import CATEGORY, SCENE, SIZE, Seen, match_tours, scores
from ovman.language.vocabulary import nouns
from ovman.perception.backprojection import Camera, median_point, single_ray_point, world_points
from ovman.perception.labels import intersection_over_union
from ovman.records.visit import TourError
from tests.analysis.fabricated import named
from tests.analysis.recordings import MIN_MASK_PX, SIDE, detected, mask, write_scene, write_visit
from tests.episodes import episode_record
from training.detector import count_matches


def scene_in(path) -> TrueScene:
    (scene,) = read_scenes([write_scene(path)])
    return scene


def blocks(side=60):
    """Three instances side by side: 1200, 800 and 40 px."""
    ids = np.full((side, side), -1)
    ids[:40, :30], ids[:40, 30:50], ids[50:54, 50:] = 0, 1, 2
    return ids


def masks_of(ids, numbers):
    return np.stack([ids == number for number in numbers])


@pytest.mark.parametrize(("shift", "right"), [(0, True), (9, True), (11, False), (-11, False)])
def test_half_an_overlap_is_asked_for(shift, right):
    # Two rectangles 30 wide that lie s apart overlap by (30 - s) / (30 + s): a half at s = 10.
    ids = np.full((60, 60), -1)
    ids[:40, 15:45] = 0
    shifted = np.roll(ids == 0, shift, axis=1)[None]
    one = match_masks(shifted, np.array([0.9]), ids, 1, 300)
    assert (one.object[0] == 0) == right == one.recalled[0]


def test_of_equally_sure_masks_the_first_is_not_the_double():
    # Sorting that is not stable keeps the order of a few equal values only by chance; of these hundreds it does not.
    rng = np.random.default_rng(0)
    ids = np.arange(40).reshape(5, 8)
    shows, confidence = rng.integers(0, 40, 400), rng.choice([0.5, 0.7, 0.9], 400)
    whole = match_masks(masks_of(ids, shows), confidence, ids, 40, 1)
    first = {}
    for n in sorted(range(400), key=lambda n: -confidence[n]):
        first.setdefault(shows[n], n)
    assert whole.object.tolist() == shows.tolist()
    assert np.flatnonzero(~whole.doubled).tolist() == sorted(first.values())


@pytest.mark.parametrize(("least", "counted"), [(799, [0, 1]), (800, [0, 1]), (801, [0])])
def test_an_instance_of_just_the_least_size_counts(least, counted):
    ids = blocks()
    whole = match_masks(masks_of(ids, [0, 1]), np.array([0.9, 0.8]), ids, 3, least)
    assert whole.true_object.tolist() == counted and whole.true_px.tolist() == [1200, 800][: len(counted)]
    # Whether an instance is large enough does not make a mask on it wrong.
    assert whole.object.tolist() == [0, 1]


@pytest.mark.parametrize("count", [0, 3])
def test_views_without_masks_or_without_instances(count):
    ids = blocks() if count else np.full((60, 60), -1)
    none = match_masks(np.zeros((0, 60, 60), bool), np.zeros(0), ids, count, 300)
    assert len(none.px) == 0 and not none.recalled.any()
    assert match_masks((ids == -1)[None], np.array([0.5]), ids, count, 300).object.tolist() == [-1]


def test_it_counts_as_overlap_does():
    rng = np.random.default_rng(0)
    parts, total = [], None
    for _ in range(30):
        ids = np.kron(rng.integers(-1, 4, (5, 5)), np.ones((12, 12), int))
        masks = np.stack([np.roll(ids == rng.integers(0, 4), rng.integers(0, 9), axis=1) for _ in range(6)])
        masks = masks[masks.any(axis=(1, 2))]
        parts.append(match_masks(masks, rng.random(len(masks)), ids, 4, 300))
        counts = count_matches(*intersection_over_union(masks, ids, 4), 300)
        total = counts if total is None else total + counts
    assert sum(len(part.true_px) for part in parts) == total.true and sum(part.recalled.sum() for part in parts) == total.recalled
    assert sum(len(part.px) for part in parts) == total.found and sum((part.object >= 0).sum() for part in parts) == total.right
    assert 0 < total.right < total.found and 0 < total.recalled < total.true


CAMERA = Camera((0.0, 1.5, 0.0), 0.0, 0.0, 90.0)
BOX = TrueObject("Box|1", "Box", (1.0, 2.0, 3.0), (0.2, 0.4, 0.6))


def wall_on_the_right(side=200):
    """Depth (H, W) of the plane x = 1, infinite where the camera does not see it, and the heights above the camera."""
    u = (np.arange(side) + 0.5 - side / 2) / (side / 2)
    depth = np.where(u > 0, 1 / np.maximum(u, 1e-9), np.inf)[None, :].repeat(side, axis=0)
    return depth, -u[:, None] * depth


def around(points, thickness=1e-6):
    low, high = points.min(axis=0) - thickness, points.max(axis=0) + thickness
    return TrueObject("L|1", "L", tuple((low + high) / 2), tuple(high - low))


def test_the_single_ray_is_worse_on_an_l():
    depth, height = wall_on_the_right()
    upright = (depth < 1.6) & (abs(height) < 0.8)
    lying = (depth < 9) & (height < -0.5) & (height > -0.8)
    mask = (upright | lying) & (depth > 1.1)
    box = around(world_points(depth, mask, CAMERA))
    assert box_distance_m(median_point(depth, mask, CAMERA), box) == 0.0
    assert box_distance_m(single_ray_point(depth, mask, CAMERA), box) > 0.03


@given(st.integers(0, 2**32 - 1))
def test_the_median_never_leaves_the_box_of_what_is_seen(seed):
    rng = np.random.default_rng(seed)
    mask = rng.random((12, 12)) < rng.uniform(0.05, 1)
    mask[rng.integers(12), rng.integers(12)] = True
    depth = rng.choice([0.4, 2.0, 20.0], mask.shape) * rng.uniform(0.9, 1.1, mask.shape)
    camera = Camera(tuple(rng.normal(size=3)), rng.uniform(0, 360), rng.uniform(-30, 60), 90.0)
    assert box_distance_m(median_point(depth, mask, camera), around(world_points(depth, mask, camera))) == 0.0


@pytest.mark.parametrize(
    ("point", "box_m", "centre_m"),
    [
        ((1.0, 2.0, 3.0), 0.0, 0.0),
        ((1.1, 2.2, 3.3), 0.0, np.hypot(0.1, 0.3)),
        ((1.4, 2.0, 3.0), 0.3, 0.4),
        ((1.0, 9.2, 3.0), 7.0, 0.0),
        ((1.4, 2.6, 3.0), 0.5, 0.4),
    ],
)
def test_distances(point, box_m, centre_m):
    assert box_distance_m(np.array(point), BOX) == pytest.approx(box_m, abs=1e-12)
    assert centre_distance_m(np.array(point), BOX) == pytest.approx(centre_m, abs=1e-12)


def test_true_and_detected_masks_of_a_tour(tmp_path):
    scene = scene_in(tmp_path)
    directory = write_visit(tmp_path / "untouched")
    seen = detected([mask("Sofa|1", 2), ~mask("Sofa|1"), mask("Vase|2")], views=[0, 0, 1])
    rows = named(list(locate_masks(scene, directory, 90.0, MIN_MASK_PX, seen)))
    assert [(r.view, r.mask, r.object) for r in rows] == [
        (0, TRUE, "Sofa|1"), (0, TRUE, "Vase|1"), (0, DETECTED, "Sofa|1"),
        (1, TRUE, "Sofa|1"), (1, TRUE, "Vase|1"), (1, DETECTED, "Vase|2"),
    ]  # fmt: skip
    left, right = 4, 34
    centre_x = ((left + right) / 2 - SIDE / 2) / (SIDE / 2) * 2.0
    assert rows[0].median_centre_m == pytest.approx(abs(centre_x - 0.0), abs=1e-9)
    assert rows[0].px == mask("Sofa|1").sum()
    assert {r.scene for r in rows} == {"FloorPlan1"} and all(r.category == r.object.split("|")[0] for r in rows)
    assert named(list(locate_masks(scene, directory, 90.0, MIN_MASK_PX, None))) == [r for r in rows if r.mask == TRUE]


@pytest.mark.parametrize(
    "changes",
    [{"alterations": [{"kind": "disable", "instance": "Vase|1"}]}, {"moved": {"Vase|1": {"x": 0.0, "y": 0.5, "z": 2.0}}}],
)
def test_a_visit_with_changes_is_refused(tmp_path, changes):
    scene = scene_in(tmp_path)
    with pytest.raises(ValueError, match="something moves in this visit"):
        list(locate_masks(scene, write_visit(tmp_path / "visit", **changes), 90.0, MIN_MASK_PX, None))


def test_a_picture_that_is_gone_is_named(tmp_path):
    scene = scene_in(tmp_path)
    directory = write_visit(tmp_path / "untouched")
    (directory / "01_ids.png").unlink()
    with pytest.raises(TourError, match="01_ids.png: No such file or directory; record it again: snakemake"):
        list(locate_masks(scene, directory, 90.0, MIN_MASK_PX, None))


def test_pixels_are_objects_of_the_scene_or_none(tmp_path):
    scene = scene_in(tmp_path)
    ids = scene.ids(np.array([[0, 1, 2], [3, 2, 0]], np.uint16), ["wall|1", "Vase|1", "Sofa|1"])
    assert [one.id for one in scene.objects[:2]] == ["Sofa|1", "Vase|1"]
    assert ids.dtype == np.int32 and ids.tolist() == [[-1, -1, 1], [0, 1, -1]]


PHRASES = sorted({phrase for category in ("Sofa", "Vase") for phrase in nouns(category)})
TEXT = {phrase: np.eye(len(PHRASES))[i] for i, phrase in enumerate(PHRASES)}
LARGE = ("Sofa|1", "Vase|1")


def feature(name):
    return TEXT[nouns(name.split("|")[0])[0]]


def perfect(views=2, content="a", names=LARGE, shift=0, **changes):
    shown = [(view, name) for view in range(views) for name in names]
    masks = [mask(name, shift) for _, name in shown]
    settings = {"features": [feature(name) for _, name in shown], "views": [view for view, _ in shown], "content": content}
    return detected(masks, **(settings | changes))


@pytest.fixture
def scene(tmp_path):
    write_visit(tmp_path / "visits" / "FloorPlan1" / "untouched")
    return scene_in(tmp_path / "scenes")


def seen(scene, tmp_path, tours):
    return match_tours(scene, tours, TEXT, tmp_path / "visits" / "FloorPlan1", MIN_MASK_PX)


def together(parts):
    return Seen(*(pd.concat([getattr(part, name) for part in parts], ignore_index=True) for name in ("true", "masks")))


def all_of(scene, tmp_path, detections):
    return scores(seen(scene, tmp_path, {"untouched": detections}))[0]


def test_perfect_masks_and_features_are_perfect(scene, tmp_path):
    whole = all_of(scene, tmp_path, perfect())
    assert (whole.true, whole.found, whole.crops, whole.doubled) == (4, 4, 4, 0)
    assert whole.recall == whole.precision == whole.top1 == whole.top5 == 1.0
    # Synonyms point elsewhere in this language: to no category at all, so that every other one ties.
    assert whole.own_top1 == 1.0 and whole.synonym_top1 == 0.0 and whole.synonym_top5 == 1.0
    assert whole.chance_top1 == 0.5


def test_floors_walls_and_specks_are_no_instances_to_find(scene, tmp_path):
    assert [o.category for o in scene.objects] == ["Sofa", "Vase", "Vase"]
    whole = all_of(scene, tmp_path, detected([mask("Floor|1"), mask("Vase|2")], features=[feature("Vase|2")] * 2))
    assert (whole.true, whole.recalled, whole.found, whole.right) == (4, 0, 2, 1)


def test_without_any_mask(scene, tmp_path):
    whole = all_of(scene, tmp_path, detected([], features=np.zeros((0, len(PHRASES)))))
    assert whole.recall == 0.0 and whole.precision is None and whole.top1 is None and whole.off_box_median_m is None


def test_how_far_from_the_box_what_has_not_moved_is(scene, tmp_path):
    here, there = {"x": 0.0, "y": 0.5, "z": 2.0}, {"x": 5.0, "y": 0.5, "z": 2.0}
    write_visit(
        tmp_path / "visits" / "FloorPlan1" / "displaced",
        present={"Sofa|1": {"category": "Sofa", "position": here}, "Vase|1": {"category": "Vase", "position": there}},
    )
    tours = {"displaced": perfect(views=1, points=[[0.0, 0.5, 3.3], [9.0, 9.0, 9.0]])}
    whole = scores(seen(scene, tmp_path, tours))[0]
    assert whole.crops == 2 and whole.off_box_median_m == pytest.approx(1.0)


@pytest.mark.parametrize(("x", "counts"), [(0.001, True), (0.0011, False), (None, True)])
def test_what_a_visit_does_not_list_or_has_a_millimetre_off_stays_where_it_is(scene, tmp_path, x, counts):
    sofa = {"category": "Sofa", "position": {"x": x, "y": 0.5, "z": 2.0}}
    write_visit(tmp_path / "visits" / "FloorPlan1" / "again", present={} if x is None else {"Sofa|1": sofa})
    found = seen(scene, tmp_path, {"again": perfect(views=1, names=("Sofa|1",), points=[[0.0, 0.5, 3.3]])})
    assert found.masks["off_box_m"].tolist() == pytest.approx([1.0 if counts else np.nan], nan_ok=True)


def test_equal_tours_count_once_whatever_their_names():
    tours = {"b": perfect(content="x"), "a": perfect(content="x"), "c": perfect(content="y")}
    assert list(perception.distinct_tours(tours)) == list(perception.distinct_tours(dict(reversed(tours.items())))) == ["a", "c"]


def test_the_stage_is_deterministic(scene, tmp_path, monkeypatch, capsys):
    tours = {"untouched": perfect(), "again": perfect(content="a")}
    monkeypatch.setattr(perception, "read_detections", lambda path: {detections[0]: tours}[path])
    monkeypatch.setattr(perception, "read_nouns", lambda path: {tmp_path / "nouns.npz": TEXT}[path])
    constants = SimpleNamespace(perception=SimpleNamespace(detector=SimpleNamespace(min_mask_px=MIN_MASK_PX)))
    write_visit(tmp_path / "visits" / "FloorPlan1" / "again")
    toured = episode_record("moved", scene="FloorPlan1", visits={"first": "untouched", "second": "again"})
    (tmp_path / "episodes.jsonl").write_text(json.dumps(toured) + "\n")
    tours["of another split"] = perfect(content="b")
    scenes, detections = [tmp_path / "scenes" / "FloorPlan1.json"], [tmp_path / "FloorPlan1.npz"]
    where = scenes, detections, [tmp_path / "episodes.jsonl"], tmp_path / "nouns.npz", tmp_path / "visits"
    for name in ("one.csv", "other.csv"):
        perception.write_perception(*where, constants, tmp_path / name)
        tours = dict(reversed(tours.items()))
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    rows = list(csv.DictReader((tmp_path / "one.csv").open()))
    assert set(capsys.readouterr().out.splitlines()) == {"4 true masks, 4 detected ones"}
    assert rows[0]["true"] == "4" and rows[0]["recall"] == "1.000000"


def test_groups_add_up(scene, tmp_path):
    rng = np.random.default_rng(0)
    for number in range(3):
        write_visit(tmp_path / "visits" / "FloorPlan1" / f"visit{number}", views=4)

    def tour(content):
        names = rng.choice([*LARGE, "Vase|2", "Floor|1"], 12)
        masks = [mask(name, rng.integers(-4, 2)) for name in names]
        features, views = rng.normal(size=(12, len(PHRASES))), np.sort(rng.integers(4, size=12))
        return detected(masks, features=features, views=views, content=content)

    halves = [seen(scene, tmp_path, {f"visit{n}": tour(str(n)) for n in numbers}) for numbers in ((0, 1), (2,))]
    for table in (halves[1].true, halves[1].masks):
        table["scene"] = "FloorPlan2"
    rows = scores(together(halves))
    whole, members = rows[0], ("true", "recalled", "right", "doubled", "crops", "named")
    assert whole.true == 3 * 4 * 2 and whole.found == 36 and 0 < whole.right < 36
    for group in (SIZE, SCENE, CATEGORY):
        for member in members if group == CATEGORY else (*members, "found"):
            assert sum(getattr(row, member) for row in rows if row.group == group) == getattr(whole, member), (group, member)
    assert [row.value for row in rows if row.group == SCENE] == ["FloorPlan1", "FloorPlan2"]
    assert rows[1].top1 == pytest.approx(np.mean([row.top1 for row in rows if row.group == CATEGORY]))
