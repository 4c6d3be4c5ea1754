"""Records: rounding, bytes, and errors that say where and what to do; and what an episode record holds."""

from __future__ import annotations

import copy
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ovman.records.episode import Episode
from ovman.records.record import RecordError, line, lines, records, rounded
from ovman.records.scene import Alteration
from ovman.records.trial import Trial
from ovman.records.visit import Sightings
from ovman.task import referents, success
from tests.arms import CONFIG
from tests.episodes import DATA, episode_record, released

EPISODES = DATA / "episodes"
HERE = [{"id": f"Chair|{k}", "category": "Chair", "x": x, "z": 0.0} for k, x in ((1, 2.0), (2, -2.0))]
BEFORE = [HERE[0] | {"x": 0.0}, HERE[1]]
MOVED = episode_record("moved", 3, scene="FloorPlan201", world=HERE) | {"target": "Chair|1", "world_1": BEFORE}
MOVED["changes"][0]["instance"] = "Chair|1"
RUN, TOUR, PROTOCOL = MOVED["certification"][0], MOVED["tours"]["first"], MOVED["protocol"]


def moving():
    record = copy.deepcopy(MOVED) | {"id": "FloorPlan201/moving/0000", "relation": "moving"}
    path = [{"x": 0.0, "z": 0.0}, {"x": 0.1, "z": 0.0}, {"x": 2.0, "z": 0.0}]
    roam = {"x": 0.0, "z": 0.0, "step_m": 0.1, "rows": [[0, 0, 25]]}
    record["changes"][0] |= {"kind": "motion", "path": path, "placement": None, "height_m": None, "roam": roam}
    record["movers"] = [{"instance": "Chair|1", "position": {"x": 2.0, "z": 0.0}, "heading_deg": 270}]
    record["drift_m"] = {}
    return record


REMOVED = {"id": "FloorPlan201/removed/12", "relation": "removed", "world_1": []}
STABLE = {"id": "FloorPlan201/stable/0001", "relation": "stable", "target": "Chair|2"}


# --- rounding -------------------------------------------------------------------------------------

KEYS = st.sampled_from(["x", "z", "yaw_deg", "answer_distance_m", "spl", "probability", "seed", "Chair|1"])
SCALARS = st.one_of(st.none(), st.booleans(), st.integers(-(2**40), 2**40), st.floats(-1e4, 1e4), st.text(max_size=3))
VALUES = st.recursive(SCALARS, lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(KEYS, inner, max_size=3)))


@given(VALUES)
def test_rounding_twice_is_rounding_once_and_survives_the_file(value):
    once = rounded(value)
    assert rounded(once) == once
    text = line({"value": value})
    assert text.endswith("}\n") and text.count("\n") == 1
    assert line(json.loads(text)) == text


@given(st.floats(-100.0, 100.0), st.sampled_from(["x", "yaw_deg"]))
def test_the_last_bit_of_the_processor_does_not_reach_the_file(value, key):
    unit = 10_000 if key == "x" else 100
    steady = (round(value * unit) + 0.25) / unit
    assert line({key: float(np.nextafter(steady, 1e9))}) == line({key: float(np.nextafter(steady, -1e9))})


def test_integers_and_numpy_numbers_and_negative_zero():
    value = {"seed": 3, "actions": np.int64(31), "x": np.float32(0.1), "z": -0.0, "yaw_deg": -0.001, "ok": True}
    assert line(value) == '{"seed":3,"actions":31,"x":0.1,"z":0.0,"yaw_deg":0.0,"ok":true}\n'
    assert rounded({"pixels": (1, 2), "x": np.array([0.12345, 1.0])}) == {"pixels": [1, 2], "x": [0.1235, 1.0]}


@pytest.mark.parametrize("value", [float("nan"), float("inf")])
def test_a_number_that_is_not_finite_is_refused(value):
    with pytest.raises(ValueError, match="answer_distance_m is"):
        line({"answer_distance_m": value})


# --- episodes -------------------------------------------------------------------------------------


def test_the_released_episodes_come_back_byte_for_byte():
    assert lines(Episode.load(EPISODES / "main.jsonl")) == (EPISODES / "main.jsonl").read_text(encoding="utf-8")
    released = Sightings.read(DATA / "sightings" / "main.jsonl")
    assert "".join(record.to_line() for record in released) == (DATA / "sightings" / "main.jsonl").read_text(encoding="utf-8")
    assert [record.episode for record in released] == [episode.id for episode in Episode.load(EPISODES / "main.jsonl")]


def test_an_episode_can_be_judged_from_its_record():
    for episode in released():
        assert referents(*episode.states, episode.query, CONFIG) == (episode.target,)
        assert episode.alike and {*episode.scripted, *episode.others} == {*episode.changes}
        for run in episode.certification:
            assert success(run.measurement, episode.relation, CONFIG.success) == run.success


def test_an_episode_says_how_its_visits_are_brought_about():
    of_trials = {trial.candidate.id: trial.candidate for trial in Trial.read(DATA / "trials" / "everyday.jsonl")}
    for episode in Episode.load(EPISODES / "everyday.jsonl"):
        candidate = of_trials[episode.id]
        assert (episode.alterations("first"), episode.alterations("second")) == (candidate.first, candidate.second)
        assert episode.gone == {one.instance for one in candidate.second if one.kind == "disable"}


def test_an_episode_has_the_constants_of_its_protocol_and_no_others():
    constants = Episode.from_json(MOVED).settings
    for name in ("camera", "primitives", "mover", "success"):
        assert dict(getattr(constants, name)) == dict(getattr(CONFIG, name))
    assert (constants.benchmark.seed, constants.benchmark.backend) == (0, "embedded")
    for read in (lambda: constants.association.gate_m, lambda: constants.maps.cluster_radius_m, lambda: constants.tour.waypoints):
        with pytest.raises(AttributeError, match="episode FloorPlan201/moved/0003"):
            read()


def test_the_path_of_a_mover_is_its_track_unless_one_was_recorded():
    record = moving()
    mover = Episode.from_json(record).states[1]["Chair|1"]
    assert mover.track == ((0.0, 0.0), (0.1, 0.0), (2.0, 0.0)) and mover.position == (2.0, 0.0)
    record["world_2"][0]["track"] = [{"x": 0.5, "z": 0.0}, {"x": 2.0, "z": 0.0}]
    assert Episode.from_json(record).states[1]["Chair|1"].track == ((0.5, 0.0), (2.0, 0.0))
    assert Episode.from_json(record).to_line() == line(record)


def without(record, key):
    return {name: value for name, value in record.items() if name != key}


def change(**values):
    return {"changes": [MOVED["changes"][0] | values]}


CONTRADICTIONS = [
    (MOVED | {"schema": "ovman-episode/1"}, "schema: expected 'ovman-episode/4', found 'ovman-episode/1'"),
    (without(MOVED, "schema"), "schema: the key is missing"),
    (without(MOVED, "spawn"), "spawn: the key is missing"),
    (without(MOVED, "sentence") | {"sentense": "x"}, "sentence: the key is missing; rename 'sentense'"),
    (MOVED | {"relation": "mooved"}, 'relation: "mooved" is not one of'),
    (MOVED | {"spawn": {"x": "left", "z": 0.0, "yaw_deg": 0.0}}, 'spawn.x: expected a number, found "left"'),
    (MOVED | {"spawn": [0.0, 1.0]}, "spawn: expected an object, found [0.0, 1.0]"),
    (MOVED | {"shortest_path_m": -1.0}, "shortest_path_m: expected at least 0, found -1.0"),
    (MOVED | {"shortest_path_m": float("inf")}, "shortest_path_m: expected a finite number"),
    (MOVED | {"changes": {}}, "changes: expected a list"),
    (MOVED | {"changes": [MOVED["changes"][0] | {"kind": "shove"}]}, 'changes[0].kind: "shove" is not one of'),
    (MOVED | {"instances_in_category": 2.0}, "instances_in_category: expected an integer"),
    (MOVED | {"instances_in_category": 1}, "instances_in_category is 1"),
    (MOVED | {"certification": [RUN, RUN | {"success": 1}]}, "certification[1].success: expected true or false"),
    (
        MOVED | {"certification": [RUN | {"visible_px": {"down": 3}}]},
        'certification[0].visible_px.down: expected an integer, found "down"',
    ),
    (MOVED | {"certification": [RUN | {"answer_distance_m": None}]}, "certification[0]: answer_distance_m is None"),
    (MOVED | {"noun": ""}, "noun: expected text"),
    (MOVED | {"id": "FloorPlan202/moved/0003"}, "id is 'FloorPlan202/moved/0003'"),
    (MOVED | {"id": "FloorPlan201/former/0003"}, "id is 'FloorPlan201/former/0003'"),
    (MOVED | {"distractor": "Chair|2"}, "distractor is 'Chair|2'"),
    (MOVED | STABLE, "distractor is None"),
    (MOVED | {"target": "Chair|9"}, "target 'Chair|9' is no Chair of world_2"),
    (MOVED | {"category": "Vase"}, "target 'Chair|1' is no Vase of world_2"),
    (MOVED | REMOVED, "is no Chair of world_1"),
    (MOVED | {"changes": []}, "changes do not hold 'Chair|1'"),
    (MOVED | change(placement=None), "changes[0]: displace of Chair|1 has no placement"),
    (moving() | change(kind="motion"), "changes[0]: motion of Chair|1 has no roam"),
    (moving() | {"changes": [moving()["changes"][0] | {"path": None}]}, "changes[0]: motion of Chair|1 has no path"),
    (moving() | {"movers": []}, "movers: MOVING has some"),
    (MOVED | {"movers": moving()["movers"]}, "movers: MOVING has some"),
    (moving() | {"movers": [moving()["movers"][0] | {"instance": "Chair|2"}]}, "movers are ['Chair|2']"),
    (moving() | {"movers": [moving()["movers"][0] | {"heading_deg": 45}]}, "movers[0].heading_deg: 45 is not one of"),
    (
        MOVED | {"tours": {"first": TOUR, "second": TOUR | {"waypoints": []}}},
        "second.waypoints: expected a list of at least 1 element(s)",
    ),
    (MOVED | {"tours": {"first": TOUR | {"waypoints": [{"x": 1.0}]}, "second": TOUR}}, "first.waypoints[0]: z: the key is"),
    (MOVED | {"visits": {"first": "untouched"}}, "visits.second: the key is missing"),
    (MOVED | {"protocol": without(PROTOCOL, "success")}, "protocol.success: the key is missing"),
    (MOVED | {"provenance": {"seed": 1.5, "trial": "a"}}, "provenance.seed: expected an integer"),
    (MOVED | {"drift_m": {"Chair|1": -0.1}}, "drift_m.Chair|1: expected at least 0"),
    (MOVED | {"world_1": MOVED["world_1"] * 2}, "instance Chair|1 is in the world state twice"),
]


@pytest.mark.parametrize(("record", "complaint"), CONTRADICTIONS, ids=[complaint for _, complaint in CONTRADICTIONS])
def test_a_bad_record_is_one_line_with_place_key_and_remedy(record, complaint):
    with pytest.raises(RecordError) as error:
        Episode.from_json(record, "main.jsonl:7")
    message = str(error.value)
    assert message.startswith("main.jsonl:7: ") and complaint in message
    assert "\n" not in message and "; " in message


def test_errors_name_file_and_line(tmp_path):
    path = tmp_path / "main.jsonl"
    path.write_text(line(MOVED) + "\n" + line(MOVED)[:40] + "\n")
    with pytest.raises(RecordError, match=r"main.jsonl:3: not JSON"):
        Episode.load(path)
    path.write_text(line(MOVED) + line(MOVED))
    with pytest.raises(RecordError, match=r"main.jsonl:2: id: FloorPlan201/moved/0003 is in the file already"):
        Episode.load(path)
    path.write_text("")
    assert list(records(path)) == [] == Episode.load(path)


def test_the_episodes_of_a_scene_are_those_of_all_that_are_of_it():
    every = Episode.load(EPISODES / "main.jsonl")
    assert Episode.load(EPISODES / "main.jsonl", "FloorPlan201") == [one for one in every if one.scene == "FloorPlan201"] != []


@pytest.mark.parametrize("name", ["", ".", "..", "a..b", "/abs", "a/b", "../a", ".hidden", "a\\b", "a\0b", "a\n", "a" * 300])
def test_what_becomes_a_part_of_a_path_is_a_name(name):
    record = next(iter(records(EPISODES / "main.jsonl")))[1]
    others = {
        "visits.first": {"visits": {**record["visits"], "first": name}},
        "visits.second": {"visits": {**record["visits"], "second": name}},
        "scene": {"scene": name, "id": record["id"].replace(record["scene"], name, 1)},
        "split": {"split": name, "id": f"{record['scene']}/{record['relation']}/{name}-0001"},
    }
    for key, values in others.items():
        with pytest.raises(RecordError, match=f"^file:1: ({key}|id): [^\n]*$"):
            Episode.from_json(record | values, "file:1")


@pytest.mark.parametrize("instance", ["../Chair|1", "a/b", "/abs", "Chair\n|1"])
def test_the_id_of_an_instance_leads_nowhere(instance):
    with pytest.raises(RecordError, match=r"^file:1: instance: [^\n]*$"):
        Alteration.from_json({"kind": "disable", "instance": instance}, "file:1")


def test_text_is_one_line_that_says_what_it_shows():
    record = next(iter(records(EPISODES / "main.jsonl")))[1]
    for text in ("a\nb", "\x1b[31mred", "a\x85b", "\u202eback"):
        with pytest.raises(RecordError) as error:
            Episode.from_json(record | {"sentence": text}, "file:1")
        assert str(error.value).isprintable() and "file:1: sentence: " in str(error.value)


@pytest.mark.parametrize("text", ["[" * 200_000, "1" * 5_000], ids=["deep", "long"])
def test_json_that_python_cannot_hold_is_one_line(tmp_path, text):
    (tmp_path / "file.jsonl").write_text(text + "\n")
    with pytest.raises(RecordError, match=r"file\.jsonl:1: not JSON [^\n]*$"):
        list(records(tmp_path / "file.jsonl"))
