"""The stages detections, maps and nouns: what is looked at again, and what comes out."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.cache import Cache
from ovman.evaluation.observations import ObservationStore
from ovman.perception import detections, maps, networks
from ovman.perception.clusters import Detection, clusters
from ovman.perception.records import read_detections, read_maps, read_nouns
from ovman.perception.weights import WeightsError
from ovman.settings import Kind, Need, Settings
from ovman.settings.arms import ArmJob
from tests.arms import CONFIG
from tests.perception.test_tour_files import record
from tests.tour_zips import change_picture, contents, png, rewrite

PIXELS = 5


class Looks:
    """Networks that find the left half of every picture, and count the pictures."""

    side_px = 8
    contrast = 1.0

    def __init__(self) -> None:
        self.pictures = 0

    def detect(self, pictures):
        self.pictures += len(pictures)
        mask = np.zeros((1, 4, 6), bool)
        mask[:, :, :3] = True
        return [SimpleNamespace(masks=mask, confidence=np.array([0.5])) for _ in pictures]

    def images(self, crops):
        return np.tile(np.float32([1.0, 0.0]), (len(crops), 1))

    def texts(self, phrases):
        return np.array([[len(p), 0.0] for p in phrases], np.float32) / np.maximum([[len(p)] for p in phrases], 1)


@pytest.fixture
def home(tmp_path, monkeypatch):
    """Three recorded tours, two of which look the same; stand-ins for the networks, and files for their weights."""
    looks = Looks()
    monkeypatch.setattr(detections.networks, "detector_of", lambda _: looks)
    monkeypatch.setattr(detections.networks, "encoder_of", lambda _: looks)
    tours = {name: record(tmp_path / name) for name in ("untouched", "moved", "same")}
    change_picture(tours["moved"], "01_rgb.png")
    for name in ("d.safetensors", "e.safetensors", "e.json"):
        (tmp_path / name).write_text(name)
    constants = CONFIG.with_values(
        {
            "camera.field_of_view_deg": 90.0,
            "perception.detector.weights": str(tmp_path / "d.safetensors"),
            "perception.detector.min_mask_px": PIXELS,
            "perception.encoder.weights": str(tmp_path / "e.safetensors"),
            "perception.encoder.model": str(tmp_path / "e.json"),
        }
    )

    def run(output: str = "out", visits: dict[str, Path] = tours, constants: Settings = constants) -> Path:
        detections.run({"FloorPlan1": visits}, constants, Cache(tmp_path / "kept"), tmp_path / output)
        return tmp_path / output / "FloorPlan1.npz"

    return SimpleNamespace(run=run, looks=looks, constants=constants, tours=tours, directory=tmp_path)


def test_what_looks_the_same_is_looked_at_once_until_its_file_is_damaged(home):
    first = home.run().read_bytes()
    found = read_detections(home.directory / "out" / "FloorPlan1.npz")
    assert list(found) == ["untouched", "moved", "same"] and home.looks.pictures == 4
    assert found["untouched"].content == found["same"].content != found["moved"].content
    assert np.array_equal(found["untouched"].point, found["same"].point)
    assert {len(seen) for seen in found.values()} == {2} and found["moved"].pixels.tolist() == [12, 12]
    assert home.run("again").read_bytes() == first
    fewer = read_detections(home.run("fewer", visits={"moved": home.tours["moved"]}))
    assert list(fewer) == ["moved"] and home.looks.pictures == 4
    path = min((home.directory / "kept").rglob("*.npz"))
    path.write_bytes(path.read_bytes()[:-40])
    assert home.run().read_bytes() == first and home.looks.pictures == 6


OTHER = {"perception.detector.confidence": 0.3, "camera.field_of_view_deg": 80.0, "perception.device": "cuda"}


@pytest.mark.parametrize("what", ["d.safetensors", "e.safetensors", "e.json", *OTHER])
def test_other_networks_look_again(home, what):
    before = read_detections(home.run())
    if what in OTHER:
        after = read_detections(home.run(constants=home.constants.with_values({what: OTHER[what]})))
    else:
        (home.directory / what).write_text("other")
        after = read_detections(home.run())
    assert home.looks.pictures == 8
    assert all(before[name].content != after[name].content for name in before)


def test_weights_that_are_not_there_stop_before_anything_is_written(home):
    (home.directory / "d.safetensors").unlink()
    with pytest.raises(WeightsError, match="the file .*is missing"):
        home.run()
    assert not list(home.directory.rglob("FloorPlan1.npz")) and home.looks.pictures == 0


def test_true_masks_are_those_of_what_can_be_moved_in_every_view(home):
    tour, ids = home.tours["moved"], np.zeros((4, 6), np.uint16)
    ids[:, :3], ids[:, 4:] = 1, 2  # the thing in the left half and what cannot be moved
    visit = json.loads(contents(tour)["visit.json"])
    thing = {"category": "Chair", "position": {"x": 0.0, "y": 0.0, "z": 0.0}}
    views = [view | {"instances": ["Chair|1", "Fridge|1"], "moved": {}} for view in visit["views"]]
    visit = visit | {"present": {"Chair|1": thing}, "views": views}
    rewrite(tour, {"visit.json": json.dumps(visit).encode(), "00_ids.png": png(ids), "01_ids.png": png(ids)})
    arm = ArmJob(name="mine", kind=Kind.STATIC, agent="a:b", needs=(Need.NETWORKS,))
    store = ObservationStore(arm, home.constants, 90.0, home.directory, elsewhere=home.tours)
    found = store.true_detections("moved")
    assert found.view.tolist() == [0, 1] and np.array_equal(found.masks(), [ids == 1] * 2) and home.looks.pictures == 0
    assert store.true_detections("moved") is found, "looked at once"


@pytest.mark.parametrize("radius_m", [0.1, 5.0])
def test_maps_are_the_clusters_of_each_visits_detections(home, radius_m):
    source = home.run()
    maps.run(source.parent, home.constants.with_values({"maps.cluster_radius_m": radius_m}), home.directory / "maps")
    found = read_maps(home.directory / "maps" / "FloorPlan1.npz")
    for name, seen in read_detections(source).items():
        rows = zip(seen.view.tolist(), seen.point, seen.feature, strict=True)
        expected = clusters([Detection(*row) for row in rows], radius_m)
        assert len(found[name]) == len(expected)
        for there, here in zip(found[name], expected, strict=True):
            assert np.array_equal(there.position, here.position) and np.array_equal(there.track, here.track)
            assert np.allclose(there.feature, here.feature) and there.last_seen == here.last_seen
    assert list(found) == list(read_detections(source))


def test_every_noun_once_in_order(home):
    networks.write_noun_embeddings(["sofa", "bed", "sofa"], home.constants, home.directory / "nouns.npz")
    found = read_nouns(home.directory / "nouns.npz")
    assert list(found) == ["bed", "sofa"] and np.linalg.norm(found["bed"]) == pytest.approx(1.0)
