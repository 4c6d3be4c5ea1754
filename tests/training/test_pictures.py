import json

import numpy as np
import pytest

from ovman.seeds import generator
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.training.crops import Crops, true_crops
from ovman.training.picture_files import read, recorded
from ovman.training.pictures import VIEWS_A_DRAW, pictures
from ovman.training.recording import write

COUNT = VIEWS_A_DRAW + 2


@pytest.fixture(scope="module")
def simulator():
    started = controller.start("embedded", "FloorPlan202", Embodiment(120, 120, 90.0, 0.25, 30.0))
    yield started
    started.stop()


@pytest.fixture(scope="module")
def views(simulator):
    return list(pictures(simulator, "FloorPlan202", COUNT, generator(0, "pictures")))


def test_pictures_depend_on_the_seed_alone(simulator, views):
    again = list(pictures(simulator, "FloorPlan202", COUNT, generator(0, "pictures")))
    other = list(pictures(simulator, "FloorPlan202", 2, generator(1, "pictures")))
    assert len(views) == COUNT
    for one, two in zip(views, again, strict=True):
        assert (one.rgb == two.rgb).all() and (one.ids == two.ids).all() and one.objects == two.objects
    assert (views[0].rgb != other[0].rgb).any()


def test_ids_name_the_objects_of_their_own_picture_and_never_the_floor(views):
    for view in views:
        assert view.ids.min() >= -1 and view.ids.max() < len(view.objects)
        assert "Floor" not in {shown.type for shown in view.objects}
    assert any(len(view.objects) > 3 for view in views)


def test_what_is_written_is_read_again_and_cropped(views, tmp_path):
    folder = tmp_path / "FloorPlan202"
    assert write(folder, views) == COUNT
    back = list(read(recorded([folder])))
    for one, two in zip(views, back, strict=True):
        assert (one.rgb == two.rgb).all() and (one.ids == two.ids).all() and one.objects == two.objects
    assert len((folder / "objects.jsonl").read_text().splitlines()) == COUNT
    crops = true_crops(folder, 0.1, 32)
    assert crops.images.shape == (len(crops.types), 32, 32, 3) and len(crops.types) > 0
    assert set(crops.types) <= {shown.type for view in views for shown in view.objects}
    crops.write(tmp_path / "crops.npz")
    assert (Crops.read(tmp_path / "crops.npz").images == crops.images).all()
    assert json.loads((folder / "objects.jsonl").read_text().splitlines()[0]) is not None


def test_colours_of_crops_are_those_of_the_masks(views, tmp_path):
    write(tmp_path / "FloorPlan202", views)
    crops = true_crops(tmp_path / "FloorPlan202", 0.1, 32)
    view = views[0]
    sizes = np.bincount(view.ids[view.ids >= 0], minlength=len(view.objects))
    first = int(np.flatnonzero(sizes >= 150)[0])
    assert np.allclose(crops.colours[0], view.rgb[view.ids == first].mean(axis=0))
    assert crops.pixels[0] == sizes[first]
