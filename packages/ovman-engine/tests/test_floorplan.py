"""Floor plans equal the metadata: every record and box, and the start that follows from the recorded distances."""

from __future__ import annotations

import importlib.util
import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman_engine.plan import floorplan

angles = st.floats(0, 360, exclude_max=True)


@pytest.fixture(scope="module")
def database():
    folder = importlib.util.find_spec("procthor").submodule_search_locations[0]
    return json.loads(Path(folder, "databases", "ai2thor-object-metadata.json").read_bytes())


def test_every_scene_has_its_own_records(database):
    for group in floorplan.KINDS:
        for index, records in enumerate(database[group]):
            assert floorplan._records(group, index) == records
    assert [o.object_id for o in floorplan.load("FloorPlan302").objects] == [r["objectId"] for r in database["bedrooms"][1]]


def test_the_start_is_at_the_recorded_distance_from_every_object():
    for name in floorplan.names()[::4]:
        plan = floorplan.load(name)
        away = [np.linalg.norm(o.position - plan.start) - o.record["distance"] for o in plan.objects]
        assert np.abs(away).max() < 2e-3, name
        assert np.allclose(plan.start[[0, 2]] % floorplan.LATTICE_M, 0)
        assert 0.85 < plan.start[1] - plan.floor_y < 1.0


def test_the_box_of_a_movable_object_has_the_recorded_corners():
    for name in floorplan.names()[::15]:
        for item in floorplan.load(name).objects:
            recorded = item.record["objectOrientedBoundingBox"]
            if recorded is not None:
                distance = np.linalg.norm(item.box.corners()[:, None] - np.array(recorded["cornerPoints"])[None], axis=2)
                assert distance.min(axis=0).max() < 1e-2 * max(1.0, item.box.half.max())
            low, high = item.box.bounds()
            centre = item.record["axisAlignedBoundingBox"]["center"]
            if recorded is None:
                assert np.allclose((low + high) / 2, [centre[k] for k in "xyz"], atol=1e-4)


@given(angles, angles, angles)
def test_euler_angles_and_matrices_are_inverse(x, y, z):
    rotation = floorplan.rotation_matrix(np.array([x, y, z]))
    assert np.allclose(rotation @ rotation.T, np.eye(3))
    assert np.allclose(floorplan.rotation_matrix(floorplan.euler_degrees(rotation)), rotation, atol=1e-6)


def test_an_unknown_scene_is_a_key_error():
    with pytest.raises(KeyError):
        floorplan.load("FloorPlan31")


STARTS = """
from ovman_engine.plan import floorplan
print([[float(v).hex() for v in floorplan.load(name).start] for name in floorplan.names()])
"""


@pytest.mark.soak
def test_starts_are_the_same_whatever_the_processor_multiplies_matrices_with():
    """OpenBLAS has different kernels for two types of processors, with different last bits; other processors skip both."""
    found = {
        subprocess.run(
            [sys.executable, "-c", STARTS],
            env={**os.environ, "OPENBLAS_CORETYPE": core},
            capture_output=True,
            text=True,
            check=True,
        ).stdout
        for core in ("Haswell", "Nehalem")
    }
    assert len(found) == 1 and found.pop().count("0x") == 3 * len(floorplan.names())
