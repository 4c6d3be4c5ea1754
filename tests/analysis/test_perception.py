from __future__ import annotations

import csv
import json
from dataclasses import asdict, replace
from statistics import fmean, median
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.analysis import perception
from ovman.analysis.instances import TrueScene
from ovman.analysis.scores import CATEGORY, SCENE, SIZE, Score, Seen, scores
from ovman.analysis.segmentation import Segmented
from ovman.language.vocabulary import nouns
from ovman.perception.retrieval import Ranks
from tests.analysis.recordings import MIN_MASK_PX, detected, mask, write_scene, write_visit
from tests.episodes import episode_record

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
    return TrueScene.load(write_scene(tmp_path / "scenes"))


def seen(scene, tmp_path, tours):
    return perception.seen_in(scene, tours, TEXT, tmp_path / "visits" / "FloorPlan1", MIN_MASK_PX)


def all_of(scene, tmp_path, detections):
    return scores([seen(scene, tmp_path, {"untouched": detections})])[0]


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


def test_shifted_masks_find_nothing(scene, tmp_path):
    assert all_of(scene, tmp_path, perfect(names=("Sofa|1",), shift=9)).recall == 0.5
    whole = all_of(scene, tmp_path, perfect(names=("Sofa|1",), shift=11))
    assert whole.recall == whole.precision == 0.0 and whole.top1 is None


def test_masks_on_one_instance_are_told_apart(scene, tmp_path):
    whole = all_of(scene, tmp_path, perfect(views=1, names=("Sofa|1", "Sofa|1", "Vase|1")))
    assert (whole.recalled, whole.right, whole.doubled) == (2, 3, 1)
    assert whole.precision == 1.0 and whole.precision_once == pytest.approx(2 / 3)


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
    whole = scores([seen(scene, tmp_path, tours)])[0]
    assert whole.crops == 2 and whole.off_box_median_m == pytest.approx(1.0)


def test_groups_add_up(scene, tmp_path):
    rng = np.random.default_rng(0)
    for number in range(3):
        write_visit(tmp_path / "visits" / "FloorPlan1" / f"visit{number}", views=4)

    def tour(content):
        names = rng.choice([*LARGE, "Vase|2", "Floor|1"], 12)
        features = rng.normal(size=(12, len(PHRASES)))
        masks = [mask(name, rng.integers(-4, 2)) for name in names]
        return detected(masks, features=features, views=np.sort(rng.integers(4, size=12)), content=content)

    halves = [seen(scene, tmp_path, {f"visit{n}": tour(str(n)) for n in numbers}) for numbers in ((0, 1), (2,))]
    object.__setattr__(halves[1], "scene", "FloorPlan2")
    rows = scores(halves)
    whole = rows[0]
    assert whole.true == 3 * 4 * 2 and whole.found == 36 and 0 < whole.right < 36
    for group, members in ((SIZE, ("true", "recalled", "found", "right", "doubled", "crops", "named")),
                           (SCENE, ("true", "recalled", "found", "right", "doubled", "crops", "named")),
                           (CATEGORY, ("true", "recalled", "right", "doubled", "crops", "named"))):  # fmt: skip
        for member in members:
            assert sum(getattr(row, member) for row in rows if row.group == group) == getattr(whole, member), (group, member)
    assert rows[1].top1 == pytest.approx(np.mean([row.top1 for row in rows if row.group == CATEGORY]))


@pytest.mark.parametrize(("x", "counts"), [(0.001, True), (0.0011, False), (None, True)])
def test_what_a_visit_does_not_list_or_has_a_millimetre_off_stays_where_it_is(scene, tmp_path, x, counts):
    sofa = {"category": "Sofa", "position": {"x": x, "y": 0.5, "z": 2.0}}
    write_visit(tmp_path / "visits" / "FloorPlan1" / "again", present={} if x is None else {"Sofa|1": sofa})
    found = seen(scene, tmp_path, {"again": perfect(views=1, names=("Sofa|1",), points=[[0.0, 0.5, 3.3]])})
    assert found.scene == "FloorPlan1"
    assert found.off_box_m.tolist() == pytest.approx([1.0 if counts else np.nan], nan_ok=True)


def test_equal_tours_count_once_whatever_their_names():
    tours = {"b": perfect(content="x"), "a": perfect(content="x"), "c": perfect(content="y")}
    assert list(perception.distinct(tours)) == list(perception.distinct(dict(reversed(tours.items())))) == ["a", "c"]


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
        perception.run(*where, constants, tmp_path / name)
        tours = dict(reversed(tours.items()))
    assert (tmp_path / "one.csv").read_bytes() == (tmp_path / "other.csv").read_bytes()
    rows = list(csv.DictReader((tmp_path / "one.csv").open()))
    assert set(capsys.readouterr().out.splitlines()) == {"1 tours: 4 true masks, 4 detected ones"}
    assert rows[0]["true"] == "4" and rows[0]["recall"] == "1.000000"
    with pytest.raises(ValueError, match="FloorPlan1: no file of detections; make it first"):
        perception.run(where[0], [], *where[2:], constants, tmp_path / "none.csv")


SIZES = {
    "below 600 px": range(600),
    "600-1499 px": range(600, 1500),
    "1500-4999 px": range(1500, 5000),
    "5000 px and more": range(5000, 10**9),
}
"""The groups by size as the paper names them."""
CHOICES = {"FloorPlan1": ("Lamp", "Sofa", "Vase"), "FloorPlan2": ("Sofa", *(f"Thing{number:02d}" for number in range(11)))}
"""The categories of two scenes, of one object each: fewer than five in the one, and more in the other."""
CROP = ("top1", "top5", "chance_top1", "chance_top5")


def table(rng):
    """True instances and masks of both scenes, a dict each. The sizes have every border between two groups on both sides."""
    borders = [px + beside for px in (600, 1500, 5000) for beside in (-1, 0, 1)]
    instances, masks = [], []
    for scene, categories in CHOICES.items():
        for px in [*borders, *rng.integers(300, 9000, 20).tolist()]:
            category = categories[rng.integers(len(categories))]
            instances.append({"scene": scene, "category": category, "px": px, "recalled": bool(rng.integers(2))})
        for px in [*borders, *rng.integers(300, 9000, 20).tolist()]:
            # A mask on nothing has no rank and no place; a category that begins with a T has no synonyms.
            category = None if rng.random() < 0.3 else categories[rng.integers(len(categories))]
            synonyms = [] if category is None or category[0] == "T" else rng.integers(0, len(categories), 3).tolist()
            masks.append({
                "scene": scene, "category": category, "px": px, "doubled": category is not None and bool(rng.integers(2)),
                "rank": int(rng.integers(len(categories))), "synonyms": synonyms, "choices": len(categories),
                "off_m": None if rng.random() < 0.3 else float(rng.exponential()),
            })  # fmt: skip
    # Only masks show the lamp: it is too small to count as an instance.
    return [one for one in instances if one["category"] != "Lamp"], masks


def of_scene(scene, instances, masks):
    index = CHOICES[scene].index
    instances, masks = ([one for one in some if one["scene"] == scene] for some in (instances, masks))
    right = [one for one in masks if one["category"] is not None]
    whole = Segmented(
        true_object=np.array([index(one["category"]) for one in instances]),
        true_px=np.array([one["px"] for one in instances]),
        recalled=np.array([one["recalled"] for one in instances]),
        px=np.array([one["px"] for one in masks]),
        object=np.array([-1 if one["category"] is None else index(one["category"]) for one in masks]),
        object_px=np.zeros(len(masks), int),
        doubled=np.array([one["doubled"] for one in masks]),
    )
    synonyms = tuple(np.array(one["synonyms"], int) for one in right)
    ranked = Ranks(np.array([one["rank"] for one in right]), synonyms, np.array([one["choices"] for one in right]))
    off_m = np.array([np.nan if one["off_m"] is None else one["off_m"] for one in right])
    return Seen(scene, 1, CHOICES[scene], whole, ranked, off_m)


def mean(values):
    values = list(values)
    return fmean(values) if values else None


def expected(group, value, instances, masks, wrong=True):
    """The row of these instances and masks, counted one by one."""
    right = [one for one in masks if one["category"] is not None]
    named = [one for one in right if one["synonyms"]]
    off_m = sorted(one["off_m"] for one in right if one["off_m"] is not None)
    # 95 of 100 steps from the least to the greatest, between two neighbours if need be.
    low, part = divmod(95 * (len(off_m) - 1), 100)
    return Score(
        group,
        value,
        true=len(instances),
        recalled=sum(one["recalled"] for one in instances),
        recall=mean(one["recalled"] for one in instances),
        found=len(masks) if wrong else None,
        right=len(right),
        precision=mean(one["category"] is not None for one in masks) if wrong else None,
        doubled=sum(one["doubled"] for one in masks),
        precision_once=mean(one["category"] is not None and not one["doubled"] for one in masks) if wrong else None,
        crops=len(right),
        top1=mean(one["rank"] == 0 for one in right),
        top5=mean(one["rank"] < 5 for one in right),
        chance_top1=mean(1 / one["choices"] for one in right),
        chance_top5=mean(min(5 / one["choices"], 1) for one in right),
        named=len(named),
        own_top1=mean(one["rank"] == 0 for one in named),
        own_top5=mean(one["rank"] < 5 for one in named),
        synonym_top1=mean(fmean(rank == 0 for rank in one["synonyms"]) for one in named),
        synonym_top5=mean(fmean(rank < 5 for rank in one["synonyms"]) for one in named),
        off_box_median_m=median(off_m) if off_m else None,
        off_box_p95_m=off_m[low] + (part and (off_m[low + 1] - off_m[low]) * part / 100) if off_m else None,
    )


@pytest.mark.parametrize("seed", range(3))
def test_every_number_of_every_row_is_what_counting_one_by_one_gives(seed):
    instances, masks = table(np.random.default_rng(seed))
    by_category = [
        expected(CATEGORY, name, *([one for one in some if one["category"] == name] for some in (instances, masks)), wrong=False)
        for name in sorted({one["category"] for one in (*instances, *masks)} - {None})
    ]
    means = ("recall", *CROP, "own_top1", "own_top5", "synonym_top1", "synonym_top5")
    rows = [
        expected("all", "all", instances, masks),
        Score("categories", "mean", **{
            name: mean(getattr(row, name) for row in by_category if getattr(row, name) is not None) for name in means
        }),
        *(expected(SIZE, name, *([one for one in some if one["px"] in px] for some in (instances, masks)))
          for name, px in SIZES.items()),
        *(expected(SCENE, name, *([one for one in some if one["scene"] == name] for some in (instances, masks)))
          for name in ("FloorPlan2", "FloorPlan1")),
        *by_category,
    ]  # fmt: skip
    # Scenes are in the order given.
    got = scores([of_scene(scene, instances, masks) for scene in ("FloorPlan2", "FloorPlan1")])
    assert [(row.group, row.value) for row in got] == [(row.group, row.value) for row in rows]
    for row, known in zip(got, rows, strict=True):
        assert asdict(row) == pytest.approx(asdict(known)), (row.group, row.value)
    # Names are plain strings: numpy's own strings are equal to them, but a row with one prints otherwise.
    assert {type(row.value) for row in got} == {str}
    assert rows[0].own_top5 != rows[0].top5 and rows[0].chance_top5 != 1.0 and "Lamp" in {row.value for row in rows}


def test_no_scene_has_the_rows_of_nothing():
    whole, categories, *sizes = scores([])
    assert whole == expected("all", "all", [], []) and categories == Score("categories", "mean")
    assert sizes == [expected(SIZE, name, [], []) for name in SIZES]


def test_a_scene_without_masks_adds_its_instances_and_nothing_else():
    instances, masks = table(np.random.default_rng(0))
    here = [one for one in instances if one["scene"] == "FloorPlan1"]
    both = [of_scene("FloorPlan1", instances, []), of_scene("FloorPlan2", instances, masks)]
    # An empty column is one of floats, unless it was made of something else.
    assert both[0].segmented.doubled.dtype == float
    whole, alone = scores(both)[0], scores(both[1:])[0]
    assert whole == replace(alone, true=whole.true, recalled=whole.recalled, recall=whole.recall)
    assert whole.true == alone.true + len(here) and whole.recalled == alone.recalled + sum(one["recalled"] for one in here)
    assert whole.doubled > 0
