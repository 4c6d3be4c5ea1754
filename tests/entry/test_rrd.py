"""`ovman show --rrd`: the recording has both tours, the answer and the paths, where the records have them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ovman.playback import command as playback
from ovman.records.run import Score
from tests.entry.evaluations import SCENE, command
from tests.episodes import DATA, of_scene

EPISODE = of_scene(SCENE)[0]


@pytest.fixture(scope="module")
def chunks(tmp_path_factory, depth_driving):
    """The tables of the recording of an episode with the runs of an evaluation, by entity."""
    from rerun.chunk import RrdReader

    path = tmp_path_factory.mktemp("rrd") / "one.rrd"
    assert command("show", "--rrd", EPISODE.id, "--results", DATA, "--output", path, "--runs", depth_driving) == 0
    found = {}
    for chunk in RrdReader(path).stream():
        found.setdefault(chunk.entity_path, []).append(chunk.to_record_batch())
    return found


def values(chunks, entity, component):
    """What an entity has of a component, a value a row, in the order of the timeline."""
    rows = []
    for table in chunks[entity]:
        names = table.schema.names
        if component in names:
            times = next((table.column(name).to_pylist() for name in ("view", "action") if name in names), [0] * table.num_rows)
            rows += zip(times, table.column(component).to_pylist(), strict=True)
    return [value for _, value in sorted(rows, key=lambda row: row[0])]


@pytest.mark.networks
def test_both_tours_have_every_view(chunks):
    for which in ("first", "second"):
        tour = EPISODE.tours[which]
        views = len(tour.waypoints) * tour.headings
        places = values(chunks, f"/{which}/camera", "Transform3D:translation")
        stood = {(round(place[0][0], 3), round(place[0][2], 3)) for place in places}
        assert len(places) == views and stood == {(round(x, 3), round(z, 3)) for x, z in tour.waypoints}
        assert len([entity for entity in chunks if entity.startswith(f"/{which}/points/")]) == views


@pytest.mark.networks
def test_points_are_in_the_room(chunks):
    """A pixel's point lies on its ray: what is seen of a home is not beyond its walls."""
    cells = np.array([row[:3] for row in values(chunks, "/truth/reachable", "Points3D:positions")[0]])
    for entity in chunks:
        if "/points/" in entity:
            points = np.array(values(chunks, entity, "Points3D:positions")[0])
            assert points[:, 1].min() > -0.1 and points[:, 1].max() < 4.0
            assert (np.abs(np.median(points, axis=0) - np.median(cells, axis=0))[[0, 2]] < 5.0).all()


@pytest.mark.networks
def test_the_answer_is_where_the_episode_has_it(chunks):
    ((x, _, z),) = values(chunks, "/truth/answer", "Points3D:positions")[0]
    assert (x, z) == pytest.approx(EPISODE.answer, abs=1e-4)
    circle = np.array(values(chunks, "/truth/success_radius", "LineStrips3D:strips")[0][0])
    assert np.allclose(np.hypot(circle[:, 0] - x, circle[:, 2] - z), EPISODE.protocol.success.radius_m, atol=1e-4)


@pytest.mark.networks
def test_paths_end_where_the_runs_stopped(chunks, depth_driving):
    runs = [run for run in Score.read(depth_driving / "runs.jsonl") if run.episode == EPISODE.id]
    assert len(runs) == 2
    for run in runs:
        base = f"/arms/{run.arm}/seed{run.seed}"
        path = np.array(values(chunks, f"{base}/path", "LineStrips3D:strips")[0][0])
        assert (path[-1][0], path[-1][2]) == pytest.approx((run.stop.x, run.stop.z), abs=1e-3)
        assert sum(math.hypot(*step) for step in np.diff(path[:, [0, 2]], axis=0)) == pytest.approx(run.path_length_m, abs=1e-3)
        assert len(values(chunks, f"{base}/agent", "Arrows3D:vectors")) == len(run.trace)


def test_without_rerun_it_is_one_line(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(playback, "find_spec", lambda name: None)
    assert command("show", "--rrd", EPISODE.id, "--results", DATA, "--output", tmp_path / "x.rrd") == 1
    assert capsys.readouterr().err == "ovman show: rerun-sdk is not installed; in a checkout of OVMAN: pip install '.[rerun]'\n"


def test_an_unknown_episode_is_one_line(monkeypatch, capsys, tmp_path):
    monkeypatch.setattr(playback, "find_spec", lambda name: name)
    assert command("show", "--rrd", "FloorPlan10/moved/9999", "--results", DATA, "--output", tmp_path / "x.rrd") == 1
    assert capsys.readouterr().err.count("\n") == 1 and not list(tmp_path.iterdir())
