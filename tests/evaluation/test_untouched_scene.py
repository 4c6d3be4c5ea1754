"""The untouched scene in a context: the grid for arms that need it, looks only for arms that are given positions."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ovman.evaluation.context import EpisodeContext
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.true_grounding import read_looks
from ovman.homes.generate import digest_house, generate
from tests.episodes import released, scene_record, sightings
from tests.runs import job

EPISODE = released()[0]


def context(arm, scene=None, seen=None):
    of_arm, settings = job(arm)
    store = ObservationStore(of_arm, settings, 90.0, Path("none"))
    return EpisodeContext(np.random.default_rng(0), 0, settings, EPISODE, of_arm, store, seen, scene=scene)


def test_the_grid_is_that_of_the_scene_and_only_for_arms_that_need_it():
    scene = scene_record(EPISODE.scene)
    assert context("layout_prior", scene).grid.tolist() == [list(cell) for cell in scene.reachable]
    with pytest.raises(ValueError, match=r"arms.two_visits is given no scene; write needs: \[scene\] in its entry"):
        _ = context("two_visits", scene).grid
    with pytest.raises(ValueError, match=f"arms.layout_prior needs the record of {EPISODE.scene}"):
        _ = context("layout_prior").grid


def test_looks_are_for_diagnostics_alone():
    scene = scene_record(EPISODE.scene)
    looks = context("ideal_observer", scene, sightings()[EPISODE.id]).looks
    assert {*looks} == {one.id for one in scene.objects}
    with pytest.raises(ValueError, match="arms.layout_prior finds its positions itself"):
        _ = context("layout_prior", scene).looks


def test_looks_of_a_home_are_its_assets():
    house = generate("5", 1, "test")
    scene = scene_record("FloorPlan201").model_copy(update={"scene": f"Home-test-1-5-{digest_house(house)}"})
    looks = read_looks(scene)
    for thing in house["objects"]:
        assert looks[thing["id"]] == thing["assetId"]
        assert all(looks[child["id"]] == child["assetId"] for child in thing["children"])


def test_looks_of_a_floor_plan_are_sizes_that_a_quarter_turn_does_not_change():
    scene = scene_record("FloorPlan201")

    def resized(change):
        things = [one.model_copy(update={"size": change(one.size)}) for one in scene.objects]
        return read_looks(scene.model_copy(update={"objects": tuple(things)}))

    assert read_looks(scene) == resized(lambda size: size.model_copy(update={"x": size.z, "z": size.x}))
    larger = resized(lambda size: size.model_copy(update={"y": size.y + 0.1}))
    assert not {*read_looks(scene).items()} & {*larger.items()}
