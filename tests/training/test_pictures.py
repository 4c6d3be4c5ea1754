from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.seeds import generator
from ovman.settings.config import load
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from training.crops import Crops, roughen, run_true
from training.pictures import (
    MIN_MASK_PX,
    VIEWS_A_DRAW,
    label_lines,
    list_pictures,
    outline,
    read_pictures,
    take_pictures,
    write_pictures,
)

CONFIG = load(Path(__file__).parents[2] / "config.yaml")
COUNT = VIEWS_A_DRAW + 2
SIDE = 60


@pytest.fixture(scope="module")
def simulator():
    started = controller.start("embedded", "FloorPlan202", Embodiment(120, 120, 90.0, 0.25, 30.0))
    yield started
    started.stop()


@pytest.fixture(scope="module")
def views(simulator):
    return list(take_pictures(simulator, "FloorPlan202", COUNT, generator(0, "pictures")))


def test_pictures_depend_on_the_seed_alone(simulator, views):
    again = list(take_pictures(simulator, "FloorPlan202", COUNT, generator(0, "pictures")))
    other = list(take_pictures(simulator, "FloorPlan202", 2, generator(1, "pictures")))
    assert len(views) == COUNT
    for one, two in zip(views, again, strict=True):
        assert (one.rgb == two.rgb).all() and (one.ids == two.ids).all() and one.objects == two.objects
    assert (views[0].rgb != other[0].rgb).any()


def test_no_picture_shows_a_category_that_is_left_out(simulator, views):
    shown = {one.type for view in views for one in view.objects}
    left_out = sorted(shown)[::2]
    without = list(take_pictures(simulator, "FloorPlan202", COUNT, generator(0, "pictures"), left_out))
    seen = {one.type for view in without for one in view.objects}
    assert len(without) == COUNT and left_out and seen and not seen & {*left_out}


def test_ids_name_the_objects_of_their_own_picture_and_never_the_floor(views):
    for view in views:
        assert view.ids.min() >= -1 and view.ids.max() < len(view.objects)
        assert "Floor" not in {shown.type for shown in view.objects}
    assert any(len(view.objects) > 3 for view in views)


def test_what_is_written_is_read_again(views, tmp_path):
    folder = tmp_path / "FloorPlan202"
    assert write_pictures(folder, views) == COUNT
    back = list(read_pictures(list_pictures([folder])))
    for one, two in zip(views, back, strict=True):
        assert (one.rgb == two.rgb).all() and (one.ids == two.ids).all() and one.objects == two.objects
    assert len((folder / "objects.jsonl").read_text().splitlines()) == COUNT


def test_crops_are_of_rough_masks_and_depend_on_the_seed_alone(views, tmp_path):
    folder = tmp_path / "FloorPlan202"
    write_pictures(folder, views)
    for name in ("one", "other"):
        run_true(folder, CONFIG, tmp_path / f"{name}.npz")
    crops, again = (Crops.read(tmp_path / f"{name}.npz") for name in ("one", "other"))
    assert crops.images.shape == (len(crops.types), 96, 96, 3) and len(crops.types) > 0
    assert (crops.images == again.images).all() and {*crops.scenes} == {"FloorPlan202"}
    assert set(crops.types) <= {shown.type for view in views for shown in view.objects}


def test_a_rough_mask_is_most_of_the_true_one():
    rng = np.random.default_rng(0)
    mask = cv2.circle(np.zeros((90, 120), np.uint8), (100, 40), 25, 1, -1).astype(bool)
    rough = [roughen(mask, rng) for _ in range(200)]
    overlaps = [(mask & one).sum() / (mask | one).sum() for one in rough]
    assert 0.85 < np.median(overlaps) < 0.95 and min(overlaps) > 0.4 and len({one.tobytes() for one in rough}) == 200
    thin = np.zeros((90, 120), bool)
    thin[40] = True
    assert all(roughen(thin, rng).any() for _ in range(50))


def filled(polygon):
    canvas = np.zeros((SIDE, SIDE), np.uint8)
    cv2.fillPoly(canvas, [np.round(polygon).astype(np.int32)], 1)
    return canvas.astype(bool)


boxes = st.lists(st.tuples(*[st.integers(2, 40)] * 2, *[st.integers(8, 16)] * 2), min_size=1, max_size=3)


@given(boxes)
def test_an_outline_covers_its_mask_whatever_its_pieces(parts):
    mask = np.zeros((SIDE, SIDE), bool)
    for x, y, width, height in parts:
        mask[y : y + height, x : x + width] = True
    drawn = filled(outline(mask))
    assert not (mask & ~drawn).any()
    # What is too much is the seams, a pixel or two wide.
    assert (drawn & ~mask).sum() <= 3 * SIDE * (len(parts) - 1)


def test_a_speck_has_no_outline():
    mask = np.zeros((SIDE, SIDE), bool)
    mask[5:8, 5:8] = True
    assert outline(mask) is None


def test_labels_are_one_line_for_each_large_instance_in_fractions_of_the_picture():
    ids = np.full((SIDE, SIDE), -1)
    ids[5:25, 5:25], ids[30:34, 30:34], ids[40:55, 10:50] = 0, 1, 2
    lines = label_lines(ids)
    assert MIN_MASK_PX > 4 * 4 and len(lines) == 2
    for line in lines:
        cls, *points = line.split()
        assert cls == "0" and len(points) % 2 == 0 and all(0 <= float(p) <= 1 for p in points)
