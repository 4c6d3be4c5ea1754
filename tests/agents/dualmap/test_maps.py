"""DualMap's maps of each visit and through both: their places, members, runs, files, and the stage."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ovman.agents.dualmap import maps
from ovman.agents.dualmap.mapped import COLUMNS, Mapped, RunMaps, read, write
from ovman.agents.dualmap.maps import map_run
from ovman.agents.dualmap.observations import Shot, Walks, write_walks
from ovman.records.record import lines
from ovman.records.task import Relation
from ovman.records.visit import VisitPair
from tests.agents.dualmap.boxworld import CONSTANTS, DENSE, FEATURES, TEN, TOUR, Box, walk
from tests.arms import CONFIG
from tests.episodes import released

SCENE = "FloorPlan1"
CUP = Box((0.05, 0.66, 0.05), (0.14, 0.14, 0.14), class_id=13)
MOVED = [TEN[0].moved(1.0, 1.8), *TEN[1:]]
WALKS = {
    "untouched": walk([*TEN, CUP], DENSE, seed=1, runs=3),
    "displaced": walk([*MOVED, CUP], DENSE, seed=2, runs=3),
    "absent": walk(TEN[1:], DENSE, seed=3, runs=3),
}
PAIRS = [("untouched", "displaced"), ("untouched", "absent"), ("absent", "untouched")]


def made(number: int = 0, walks=WALKS, pairs=PAIRS) -> RunMaps:
    return map_run(number, SCENE, Walks(walks, FEATURES), pairs, 0, CONSTANTS.local_map)


LOCAL, OTHER = made(), made(1)


def places(mapped: Mapped, class_id: int = 0) -> list[tuple[float, ...]]:
    return sorted(tuple(place) for place in mapped.position[mapped.class_id == class_id].round(1).tolist())


def test_each_visits_map_has_what_was_there_and_a_maintained_one_former_and_present_places_side_by_side():
    assert list(LOCAL.visits) == list(WALKS) and list(LOCAL.maintained) == PAIRS
    assert places(LOCAL.visits["untouched"]) == [(0.0, 0.0)]
    assert places(LOCAL.visits["displaced"]) == [(1.0, 1.8)]
    assert places(LOCAL.visits["absent"]) == []
    assert places(LOCAL.maintained["untouched", "displaced"]) == [(0.0, 0.0), (1.0, 1.8)]
    assert places(LOCAL.maintained["untouched", "absent"]) == [(0.0, 0.0)]
    assert places(LOCAL.maintained["absent", "untouched"]) == [(0.0, 0.0)]
    for class_id in range(1, 10):
        assert len(places(LOCAL.maintained["untouched", "displaced"], class_id)) == 1
    assert LOCAL.maintained["untouched", "displaced"].frames == 2 * len(DENSE)
    mapped = LOCAL.visits["untouched"]
    found = mapped.object_map()
    assert len(found) == len(mapped) == 11 and found.last_seen == tuple(mapped.last_seen)
    assert np.array_equal(np.concatenate(found.tracks), found.p)
    assert np.linalg.norm(found.f, axis=1) == pytest.approx(1)


def test_a_maintained_map_goes_on_from_the_first_visit_as_if_it_had_been_one_walk():
    whole = made(0, {"one": [*WALKS["untouched"], *WALKS["displaced"]]}, []).visits["one"]

    def content(mapped: Mapped) -> list:
        columns = mapped.position.tolist(), mapped.class_id, mapped.first_seen, mapped.last_seen, map(tuple, mapped.members)
        return sorted(zip(*columns, strict=True))

    assert content(whole) == content(LOCAL.maintained["untouched", "displaced"])


def test_every_object_knows_its_observations_and_a_maintained_map_counts_them_through_both_walks():
    """An observation shows the class that the boxes say; objects of other classes have none of it."""
    shows = {(name,): [one.class_id for seen in frames for one in seen] for name, frames in WALKS.items()}
    shows |= {pair: shows[pair[:1]] + shows[pair[1:]] for pair in PAIRS}
    for names, mapped in [*(((name,), one) for name, one in LOCAL.visits.items()), *LOCAL.maintained.items()]:
        every = np.concatenate(mapped.members).tolist()
        assert len(every) == len({*every}) and max(every) >= sum(len(shows[name,]) for name in names[:-1])
        for class_id, members in zip(mapped.class_id, mapped.members, strict=True):
            assert {shows[names][k] for k in members} == {class_id}


def test_runs_differ_in_their_points_and_orders_and_maps_are_read_as_they_were_written(tmp_path: Path):
    for name, runs in (("once", [LOCAL, OTHER]), ("again", [made(number) for number in (0, 1)])):
        write(tmp_path / name, runs)
    assert (tmp_path / "once").read_bytes() == (tmp_path / "again").read_bytes()
    one, other = read(tmp_path / "once")
    for name in WALKS:
        p, q = one.visits[name].object_map().p, other.visits[name].object_map().p
        assert {tuple(row) for row in p}.isdisjoint(map(tuple, q))
        assert one.visits[name].class_id.tolist() != other.visits[name].class_id.tolist()
    for was, now in ((LOCAL, one), (OTHER, other)):
        for before, after in ((was.visits, now.visits), (was.maintained, now.maintained)):
            assert list(before) == list(after)
            for a, b in zip(before.values(), after.values(), strict=True):
                assert a.frames == b.frames and all(map(np.array_equal, a.members, b.members))
                for column in set(COLUMNS) - {"feature"}:
                    assert np.array_equal(getattr(a, column), getattr(b, column))
                assert a.feature == pytest.approx(b.feature, abs=1e-6)


def make_maps(directory: Path, pairs: list[tuple[str, str]], visits: list[str]) -> Path:
    """The file of the stage's maps, from walks of these visits and an episode for each pair."""
    frames, shots, taken = WALKS | {"glimpsed": walk(TEN, TOUR, 3, 3)}, [], {}
    for name in visits:
        numbers = range(len(shots), len(shots) + len(frames[name]))
        shots += [Shot(tuple(seen), 2.5) for seen in frames[name]]
        taken[name] = [*numbers], [0] * len(numbers)
    walks, episodes, output = (directory / name for name in ("walks", "episodes", "output"))
    walks.mkdir()
    write_walks(walks / f"{SCENE}.npz", taken, shots, [f"class {k}" for k in range(FEATURES)])
    other = next(episode for episode in released() if episode.relation is Relation.MOVED)
    told = [
        other.model_copy(
            update={"id": f"{SCENE}/moved/{k:04}", "scene": SCENE, "visits": VisitPair[str](first=first, second=second)}
        )
        for k, (first, second) in enumerate(pairs)
    ]
    episodes.write_text(lines(told))
    maps.run(episodes, walks, CONFIG, output)
    return output / f"{SCENE}.npz"


def test_every_run_has_a_map_of_each_visit_and_of_each_pair_of_visits_that_was_released(tmp_path: Path):
    runs = read(make_maps(tmp_path, [("untouched", "displaced")] * 2, ["untouched", "displaced"]))
    assert len(runs) == CONFIG.dualmap.runs == 3
    for made in runs:
        assert {name: len(mapped) for name, mapped in made.visits.items()} == {"untouched": 11, "displaced": 11}
        assert {pair: len(mapped) for pair, mapped in made.maintained.items()} == {("untouched", "displaced"): 12}


@pytest.mark.parametrize(
    ("second", "visits", "says"),
    [
        ("glimpsed", ["untouched", "glimpsed"], r"^FloorPlan1: run 0: the map of glimpsed has no object after 24 keyframes"),
        ("displaced", ["untouched"], "no walk of the visit displaced; make the stage walks again"),
    ],
)
def test_an_empty_map_and_an_episode_of_a_visit_that_was_not_walked_are_named(tmp_path: Path, second, visits, says):
    with pytest.raises(maps.MapsError, match=says):
        make_maps(tmp_path, [("untouched", second)], visits)
