"""Detected masks against true instances: matching, place, retrieval and the scores of every group."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from ovman.analysis.backprojection import DETECTED, TRUE, box_distance_m, centre_distance_m, locate_masks
from ovman.analysis.instances import match_masks, read_scenes
from ovman.analysis.perception import CATEGORY, SCENE, SIZE, Seen, distinct_tours, match_tours, scores
from ovman.language.vocabulary import nouns
from ovman.records.geometry import Position
from ovman.records.scene import Scene
from tests.analysis.fabricated import named
from tests.analysis.recordings import MIN_MASK_PX, SIDE, detected, mask, write_scene, write_visit


def scene_in(path) -> Scene:
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


BOX = SimpleNamespace(position=Position(x=1.0, y=2.0, z=3.0), size=Position(x=0.2, y=0.4, z=0.6))


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


def test_tours_of_equal_content_count_once():
    assert [*distinct_tours({name: perfect(content=content) for name, content in zip("bac", "xxy", strict=True)})] == ["a", "c"]


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
