"""The stage: all maps of a scene, in every run and every way to maintain one, against a clone that stands in for DualMap."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest
from boxes import Box, spin, view

from ovman.agents.dualmap.mapped import OBJECT, read, write
from ovman_released.dualmap import Maintained, Runs
from ovman_released.dualmap_frames import write_visit
from ovman_released.dualmap_runner import Policy
from ovman_released.dualmap_setup import Installation

SOFA = Box((0.6, 0.0, 1.6), (1.4, 0.6, 2.2), 0)
CUP = Box((0.9, 0.6, 1.8), (1.0, 0.75, 1.9), 1)
LAMP = Box((-2.0, 0.0, -0.2), (-1.7, 1.5, 0.2), 2)
WORLDS = {"before": [SOFA, CUP], "after": [SOFA, CUP, LAMP]}
PAIR = ("before", "after")


def runs(kept: Path, maintained: Maintained, walk=None) -> Runs:
    def walked(name: str, directory: Path) -> None:
        write_visit(directory, (view(WORLDS[name], camera) for camera in spin(0.0, 0.0)), 0.0)

    here = Installation(Path(__file__).parent / "stand_ins" / "dualmap", Path(sys.executable))
    policy = Policy(maintained.kind, "first_only", "cpu", 60.0, seed=0)
    return Runs(here, policy, maintained, "FloorPlan1", ["sofa"], {name: [name] for name in WORLDS}, walk or walked, kept)


def places(mapped) -> np.ndarray:
    return np.round(mapped.object_map().p, 1)


def test_maps_of_both_visits_and_one_through_both(tmp_path):
    made = runs(tmp_path, Maintained.CONCATENATED_LOCAL)
    maps, nouns = made.maps(0, list(WORLDS), [PAIR])
    assert {name: len(mapped) for name, mapped in maps.visits.items()} == {"before": 2, "after": 3}
    assert maps.visits["before"].frames == 12 and maps.maintained[PAIR].frames == 24
    assert len(maps.maintained[PAIR]) == 3, "what came is added to what was there"
    assert {*maps.maintained[PAIR].sort.tolist()} == {OBJECT}
    assert places(maps.visits["after"]).tolist() == places(maps.maintained[PAIR]).tolist()
    both, lamp = maps.maintained[PAIR], int(maps.maintained[PAIR].first_seen.argmax())
    assert both.position[lamp, 0] < -1.6 and both.class_id[lamp] == 2 and both.first_seen[lamp] > 12
    assert nouns.keys() == {"sofa"}
    write(tmp_path / "maps.npz", [maps])
    (kept,) = read(tmp_path / "maps.npz")
    assert places(kept.maintained[PAIR]).tolist() == places(maps.maintained[PAIR]).tolist()
    made.clear()
    assert not list(tmp_path.glob("frames.*"))


@pytest.mark.parametrize("maintained", [Maintained.CONCATENATED_GLOBAL, Maintained.PRELOADED_GLOBAL])
def test_global_maps_have_anchors_and_what_is_on_them(tmp_path, maintained):
    maps, _ = runs(tmp_path, maintained).maps(0, [], [PAIR])
    sorts = maps.maintained[PAIR].sort.tolist()
    # An anchor of the stand-in is never merged: the preloaded one stands beside that of the second visit.
    anchors = 2 if maintained is Maintained.PRELOADED_GLOBAL else 1
    assert sorts.count("anchor") == sorts.count("related") == anchors and OBJECT not in sorts


def test_a_finished_run_is_kept_and_another_number_is_another_run(tmp_path):
    first, frames = runs(tmp_path, Maintained.CONCATENATED_LOCAL).run(0, ["before"])

    def walked_again(name, directory):
        raise AssertionError("it was kept")

    again, frames_again = runs(tmp_path, Maintained.CONCATENATED_LOCAL, walked_again).run(0, ["before"])
    assert again.columns["uid"].tolist() == first.columns["uid"].tolist() and frames_again == frames == 12
    with pytest.raises(AssertionError, match="it was kept"):
        runs(tmp_path, Maintained.CONCATENATED_LOCAL, walked_again).run(1, ["before"])
