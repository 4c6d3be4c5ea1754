"""DualMap's maps of each visit and through both: their places, members, runs, files, and the stage."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from ovman import seeds
from ovman.agents.dualmap import maps
from ovman.agents.dualmap.mapped import Mapped, RunMaps, read, write
from ovman.agents.dualmap.maps import Run
from ovman.agents.dualmap.observations import FrameObject, Shot, Taken, write_walks
from ovman.perception.array_file import ArrayFileError
from ovman.records.record import lines
from ovman.records.task import Relation
from ovman.records.visit import VisitPair
from ovman.settings.config import load
from tests.agents.dualmap.boxworld import CONSTANTS, DENSE, FEATURES, TEN, TOUR, Box, walk
from tests.episodes import released

CUP = Box((0.05, 0.66, 0.05), (0.14, 0.14, 0.14), class_id=13)
MOVED = [TEN[0].moved(1.0, 1.8), *TEN[1:]]
WALKS = {
    "untouched": walk([*TEN, CUP], DENSE, seed=1, runs=2),
    "displaced": walk([*MOVED, CUP], DENSE, seed=2, runs=2),
    "absent": walk(TEN[1:], DENSE, seed=3, runs=2),
}
PAIRS = [("untouched", "displaced"), ("untouched", "absent"), ("absent", "untouched"), ("untouched", "displaced")]


def made(number: int = 0) -> RunMaps:
    run = Run(number, FEATURES, CONSTANTS.local_map, lambda *visits: seeds.generator(0, "dualmap", *visits, number))
    return run.map_visits(WALKS, PAIRS)


LOCAL = made()


def places(mapped: Mapped, class_id: int = 0) -> list[tuple[float, ...]]:
    return sorted(tuple(e.position.round(1).tolist()) for e in mapped.entries if e.class_id == class_id)


def test_each_visits_map_has_what_was_there_and_a_maintained_one_former_and_present_places_side_by_side():
    maps = LOCAL
    assert list(maps.visits) == list(WALKS) and list(maps.maintained) == PAIRS[:3]
    assert places(maps.visits["untouched"]) == [(0.0, 0.0)]
    assert places(maps.visits["displaced"]) == [(1.0, 1.8)]
    assert places(maps.visits["absent"]) == []
    assert places(maps.maintained["untouched", "displaced"]) == [(0.0, 0.0), (1.0, 1.8)]
    assert places(maps.maintained["untouched", "absent"]) == [(0.0, 0.0)]
    assert places(maps.maintained["absent", "untouched"]) == [(0.0, 0.0)]
    for class_id in range(1, 10):
        assert len(places(maps.maintained["untouched", "displaced"], class_id)) == 1
    assert maps.maintained["untouched", "displaced"].frames == 2 * len(DENSE)


def test_a_maintained_map_goes_on_from_the_first_visit_as_if_it_had_been_one_walk():
    both = {"one": [*WALKS["untouched"], *WALKS["displaced"]]}
    whole = Run(0, FEATURES, CONSTANTS.local_map, lambda *visits: np.random.default_rng(0)).map_visits(both, []).visits["one"]
    parts = LOCAL.maintained["untouched", "displaced"]

    def content(mapped: Mapped) -> list:
        return sorted((*e.position.tolist(), e.class_id, e.observations, e.first_seen, e.last_seen) for e in mapped.entries)

    assert content(whole) == content(parts)


def test_every_object_knows_its_observations_and_a_maintained_map_counts_them_through_both_walks():
    """An observation shows the class that the boxes say; objects of other classes have none of it."""
    maps, shows = LOCAL, {name: [one.class_id for seen in frames for one in seen] for name, frames in WALKS.items()}
    for name, mapped in maps.visits.items():
        for entry in mapped.entries:
            assert {shows[name][k] for k in entry.members} == {entry.class_id}
            assert len(entry.members) == len({*entry.members.tolist()}) == entry.observations
    for pair, mapped in maps.maintained.items():
        both = [*shows[pair[0]], *shows[pair[1]]]
        every = [k for entry in mapped.entries for k in entry.members.tolist()]
        assert len(every) == len({*every}) and max(every) >= len(shows[pair[0]])
        assert all({both[k] for k in entry.members} == {entry.class_id} for entry in mapped.entries)


def test_runs_differ_in_their_points_and_orders_and_each_is_its_own_every_time(tmp_path: Path):
    files = []
    for name in ("once", "again"):
        files.append(tmp_path / f"{name}.npz")
        write(files[-1], [made(number) for number in (0, 1)])
    assert files[0].read_bytes() == files[1].read_bytes()
    one, other = read(files[0])
    for name in WALKS:
        p, q = one.visits[name].object_map().p, other.visits[name].object_map().p
        assert {tuple(row) for row in p}.isdisjoint(map(tuple, q))
        assert [e.class_id for e in one.visits[name].entries] != [e.class_id for e in other.visits[name].entries]


def test_maps_are_read_as_they_were_written(tmp_path: Path):
    path = tmp_path / "FloorPlan1.npz"
    empty = RunMaps(dict.fromkeys(LOCAL.visits, Mapped((), 5)), dict.fromkeys(LOCAL.maintained, Mapped((), 9)))
    for runs in ([LOCAL, made(1)], [LOCAL, empty], [empty]):
        write(path, runs)
        found = read(path)
        assert len(found) == len(runs)
        for was, now in zip(runs, found, strict=True):
            assert list(was.visits) == list(now.visits) and list(was.maintained) == list(now.maintained)
            for a, b in zip(
                [*was.visits.values(), *was.maintained.values()], [*now.visits.values(), *now.maintained.values()], strict=True
            ):
                assert a.frames == b.frames
                for x, y in zip(a.entries, b.entries, strict=True):
                    assert np.array_equal(x.position, y.position) and x.feature == pytest.approx(y.feature, abs=1e-6)
                    names = ("sort", "class_id", "observations", "first_seen", "last_seen")
                    assert [getattr(x, n) for n in names] == [getattr(y, n) for n in names]
                    assert np.array_equal(x.members, y.members)


def test_an_object_map_has_the_one_place_and_the_last_keyframe_of_every_object():
    mapped = LOCAL.visits["untouched"]
    found = mapped.object_map()
    assert len(found) == len(mapped.entries) == 11
    assert np.array_equal(np.concatenate(found.tracks), found.p)
    assert found.last_seen == tuple(e.last_seen for e in mapped.entries)
    assert np.linalg.norm(found.f, axis=1) == pytest.approx(1)
    assert len(Mapped((), 3).object_map()) == 0


def test_files_that_are_none_of_maps_are_refused(tmp_path: Path):
    with pytest.raises(ArrayFileError, match="make the stage dualmap"):
        read(tmp_path / "none.npz")
    with pytest.raises(ValueError, match="the same visits"):
        write(tmp_path / "x.npz", [LOCAL, RunMaps({}, {})])


CONFIG = load(Path(__file__).parents[3] / "config.yaml")
SCENE = "FloorPlan1"
DISPLACED = [TEN[0].moved(1.0, 1.8), *TEN[1:]]
FRAMES = {"untouched": walk(TEN, DENSE, 1, 3), "displaced": walk(DISPLACED, DENSE, 2, 3), "glimpsed": walk(TEN, TOUR, 3, 3)}


def files(directory: Path, pairs: list[tuple[str, str]], visits: list[str]) -> SimpleNamespace:
    """Walks of these visits, and an episode for each pair."""
    shots, taken = [], {}
    for name in visits:
        numbers = range(len(shots), len(shots) + len(FRAMES[name]))
        shots += [
            Shot(tuple(FrameObject(o.class_id, o.feature, o.confidence, o.clouds) for o in seen), 2.5) for seen in FRAMES[name]
        ]
        taken[name] = Taken(np.array(numbers), np.zeros(len(numbers), int))
    paths = SimpleNamespace(**{name: directory / name for name in ("walks", "episodes", "output")})
    paths.walks.mkdir()
    write_walks(paths.walks / f"{SCENE}.npz", taken, shots, [f"class {k}" for k in range(FEATURES)])
    other = next(episode for episode in released() if episode.relation is Relation.MOVED)
    made = [
        other.model_copy(
            update={"id": f"{SCENE}/moved/{k:04}", "scene": SCENE, "visits": VisitPair[str](first=first, second=second)}
        )
        for k, (first, second) in enumerate(pairs)
    ]
    paths.episodes.write_text(lines(made))
    return paths


def run(paths: SimpleNamespace) -> None:
    maps.run(paths.episodes, paths.walks, CONFIG, paths.output)


def test_every_run_has_a_map_of_each_visit_and_of_each_pair_of_visits_that_was_released(tmp_path: Path):
    paths = files(tmp_path, [("untouched", "displaced")] * 2, ["untouched", "displaced"])
    run(paths)
    file = paths.output / f"{SCENE}.npz"
    first, runs = file.read_bytes(), read(file)
    assert len(runs) == CONFIG.dualmap.runs == 3
    for made in runs:
        assert {name: len(mapped.entries) for name, mapped in made.visits.items()} == {"untouched": 10, "displaced": 10}
        assert {pair: len(mapped.entries) for pair, mapped in made.maintained.items()} == {("untouched", "displaced"): 11}
    run(paths)
    assert file.read_bytes() == first


def test_a_map_of_nothing_ends_the_stage_with_the_scene_and_the_visit(tmp_path: Path):
    paths = files(tmp_path, [("untouched", "glimpsed")], ["untouched", "glimpsed"])
    with pytest.raises(maps.MapsError, match=r"^FloorPlan1: run 0: the map of glimpsed has no object after 24 keyframes"):
        run(paths)
    assert not list(paths.output.iterdir())


def test_an_episode_of_a_visit_that_was_not_walked_is_named(tmp_path: Path):
    paths = files(tmp_path, [("untouched", "displaced")], ["untouched"])
    with pytest.raises(maps.MapsError, match="no walk of the visit displaced; make the stage walks again"):
        run(paths)
