"""Recorded sessions: what a simulator answered, without it; and the same asked again of another."""

from __future__ import annotations

import gzip
import json
from collections.abc import Iterator
from dataclasses import replace
from fnmatch import fnmatchcase
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

from ovman import cli
from ovman.doctor import rehearsal
from ovman.settings.settings_files import read_merged, with_parts
from ovman.sim.embodiment import Embodiment
from ovman.sim.recording.comparison import RULES, Difference, allowed, differences, summaries
from ovman.sim.recording.file import Call, Header, Recording, RecordingError, Writer, read
from ovman.sim.recording.live import replayed
from ovman.sim.recording.playback import Masks, Playback
from ovman.sim.recording.recorder import Recorder
from ovman.sim.session import Session, SimulatorError
from tests.sim import unity_build

ROOT = Path(__file__).parents[2]
SCENE = "FloorPlan429"
BODY = Embodiment(120, 120, 90.0, 0.25, 30.0)


@pytest.fixture(scope="module")
def recording_file(tmp_path_factory) -> Path:
    """The real work on a small scene, as the command records it."""
    folder = tmp_path_factory.mktemp("recording")
    settings = read_merged(with_parts(ROOT / "config.yaml"))
    settings["tour"]["waypoints"] = 1
    settings["camera"] |= {"width_px": 120, "height_px": 120}
    (folder / "config.yaml").write_text(yaml.safe_dump(settings, sort_keys=False))
    output = folder / "session.jsonl.gz"
    assert cli.main(["record", SCENE, "--output", str(output), "--config", str(folder / "config.yaml")]) == 0
    return output


@pytest.fixture(scope="module")
def recording(recording_file) -> Recording:
    return read(recording_file)


def rewritten(recording: Recording, entries, path: Path) -> Path:
    with Writer(path, recording.header) as writer:
        for entry in entries:
            writer.write(entry)
    return path


def test_the_work_is_all_that_a_visit_and_an_episode_need(recording):
    results = recording.results()
    assert set(results) >= {"survey", "moved trial", "removed trial", "moved oracle", "removed oracle"}
    assert {run["outcome"] for name, run in results.items() if name.endswith("oracle")} == {"stopped"}
    asked = {call.arguments.get("action", call.call) for _, call in recording.calls()}
    assert asked >= {
        *("start", "reset", "GetReachablePositions", "TeleportFull", "PlaceObjectAtPoint", "DisableObject"),
        *("MoveAhead", "SetObjectFilter"),
    }
    assert {call.arguments["horizon"] for _, call in recording.calls() if "horizon" in call.arguments} >= {0, 30, 60}


def test_a_recording_has_everything_but_pictures(recording_file, recording):
    with gzip.open(recording_file, "rt") as file:
        first = json.loads(file.readline())
    assert first["schema"] == "ovman-session/1" and first["backend"] == "embedded" and first["scene"] == SCENE
    assert first["versions"]["ai2thor"] == "5.0.0" and first["platform"]["system"] == "Linux"
    assert recording_file.stat().st_size < 5e6
    seen = [call for _, call in recording.calls() if call.pictures]
    assert seen and all(call.pictures.keys() == {"rgb", "depth", "masks"} for call in seen)
    assert all(sum(call.pictures["masks"].values()) <= 120 * 120 for call in seen)


def test_it_replays_both_ways_without_a_difference(recording_file, capsys):
    assert cli.main(["replay", str(recording_file)]) == 0
    out = capsys.readouterr().out
    assert "otherwise: none" in out and "0 keys differ as they may, 0 as they may not" in out


def test_a_number_that_was_changed_is_found_with_its_line_and_key(recording, tmp_path):
    """In an answer that the work makes nothing of, so that it is the simulator's answer alone that shows it."""
    entries = list(recording.entries)
    line, call = next((k, c) for k, c in recording.calls() if c.arguments.get("action") == "TeleportFull")
    agent = {**call.metadata["agent"], "cameraHorizon": call.metadata["agent"]["cameraHorizon"] + 0.5}
    entries[line - 2] = replace(call, metadata={**call.metadata, "agent": agent})
    short = read(rewritten(recording, entries[: line - 1], tmp_path / "tampered.jsonl.gz"))
    (found,) = rehearsal.compared(short, "embedded")
    assert (found.key, found.first.line, found.count) == ("agent.cameraHorizon", line, 1)
    assert found.largest == pytest.approx(0.5) and f"line {line} (TeleportFull)" in str(found)


def test_a_place_that_was_changed_changes_the_results(recording, tmp_path):
    entries = list(recording.entries)
    target = recording.results()["moved trial"]["candidate"]["target"]
    last = max(k for k, c in recording.calls() if c.metadata and any(o["objectId"] == target for o in c.metadata["objects"]))
    changed = 0
    for k, call in recording.calls():
        if call.metadata is None or call.pictures == {} or k > last:
            continue
        objects = [dict(o) for o in call.metadata["objects"]]
        for o in objects:
            if o["objectId"] == target:
                box = o["axisAlignedBoundingBox"]
                o["axisAlignedBoundingBox"] = {**box, "center": {**box["center"], "x": box["center"]["x"] + 0.01}}
                changed += 1
        entries[k - 2] = replace(call, metadata={**call.metadata, "objects": objects})
    assert changed
    assert "moved trial" in rehearsal.rehearsed(read(rewritten(recording, entries, tmp_path / "tampered.jsonl.gz")))


def test_other_work_is_told_in_a_line(recording, tmp_path):
    entries = [e for e in recording.entries if not (isinstance(e, Call) and e.arguments.get("action") == "DisableObject")]
    with pytest.raises(RecordingError, match=r"^line \d+: .* was recorded and .*DisableObject.* is asked; record it anew$"):
        rehearsal.rehearsed(read(rewritten(recording, entries, tmp_path / "other.jsonl.gz")))
    with pytest.raises(RecordingError, match="the recording ends before"):
        rehearsal.rehearsed(read(rewritten(recording, recording.entries[:4], tmp_path / "short.jsonl.gz")))
    more = [*recording.entries, Call("step", {"action": "Pass"}, None, {}, ("ValueError", "no"))]
    with pytest.raises(RecordingError, match="1 recorded calls are not asked for any more"):
        rehearsal.rehearsed(read(rewritten(recording, more, tmp_path / "long.jsonl.gz")))


def short(session: Session) -> None:
    """A few calls, one of them a mistake and one refused."""
    session.reset()
    session.step("RotateRight", image=True)
    with pytest.raises(ValueError, match="Invalid action"):
        session.step("NoSuchAction")
    with pytest.raises(SimulatorError, match="refused without a reason"):
        session.step("DisableObject", objectId="Nothing|+00.00|+00.00|+00.00")
    session.reset()
    session.step("Pass", image=True)


def constants(backend: str) -> SimpleNamespace:
    camera = SimpleNamespace(width_px=120, height_px=120, field_of_view_deg=90.0)
    primitives = SimpleNamespace(step_m=0.25, turn_deg=30.0)
    return SimpleNamespace(benchmark=SimpleNamespace(backend=backend), camera=camera, primitives=primitives)


def recorded(path: Path, backend: str) -> Recording:
    header = Header(backend, SCENE, vars(BODY), {}, {}, {})
    with Writer(path, header) as writer, Session(SCENE, constants(backend), start=Recorder.start(writer)) as session:
        short(session)
    return read(path)


def test_the_same_session_is_the_same_bytes_and_plays_back_with_its_mistakes(tmp_path):
    first, second = (tmp_path / name for name in ("a.jsonl.gz", "b.jsonl.gz"))
    recording = recorded(first, "embedded")
    recorded(second, "embedded")
    assert first.read_bytes() == second.read_bytes()
    playback = Playback(recording)
    with Session(SCENE, constants("any"), start=playback.start) as session:
        short(session)
        names = [name for name in session._event.instance_masks if name in session.objects]
        assert session.depth.shape == (120, 120) and session.rgb.shape == (120, 120, 3) and names
        known = recording.entries[-1].pictures["masks"]
        assert {name: session.pixels(name) for name in names} == {name: known[name] for name in names}
        assert session.pixels("Nothing|") == 0
    assert playback.rest() == 0


def test_what_unity_does_otherwise_is_within_the_table(tmp_path, monkeypatch):
    """Recorded where the engine plays Unity, asked again of the engine; and the other way round it is not the same calls."""
    unity_build.machine(monkeypatch, tmp_path)
    recording = recorded(tmp_path / "unity.jsonl.gz", "thor")
    found = summaries(list(replayed(recording, "embedded")), RULES)
    assert {s.key for s in found} >= {"isSceneAtRest"}
    assert [str(s) for s in found if s.rule is None] == []


@pytest.mark.parametrize(
    "content",
    [
        b"",
        b"nothing",
        gzip.compress(b""),
        gzip.compress(b'{"schema":"other"}\n'),
        gzip.compress(b'{"schema":"ovman-session/1"}\n'),
    ],
    ids=["empty", "not gzip", "no line", "another schema", "no scene"],
)
def test_what_is_no_recording_is_told_in_a_line(tmp_path, capsys, content):
    (tmp_path / "file").write_bytes(content)
    assert cli.main(["replay", str(tmp_path / "file")]) == 1
    said = capsys.readouterr().err
    assert said.startswith(f"ovman replay: {tmp_path / 'file'}: ") and said.count("\n") == 1
    assert "record" in said


def test_what_cannot_be_recorded_is_told_in_a_line(capsys, tmp_path, monkeypatch):
    assert cli.main(["record", "FloorPlan31"]) == 1
    assert capsys.readouterr().err.startswith("ovman record: FloorPlan31 is not a floor plan; there are FloorPlan1-30")
    monkeypatch.setattr("ctypes.util.find_library", lambda name: None)
    config = str(ROOT / "config.yaml")
    output = tmp_path / "session.jsonl.gz"
    assert cli.main(["record", SCENE, "--thor", "--output", str(output), "--config", config]) == 1
    said = capsys.readouterr().err
    assert (
        said.startswith("ovman record: benchmark.backend is thor, but Vulkan's library is not installed;")
        and said.count("\n") == 1
    )


def leaves(path: str, value, inside: bool = False) -> Iterator[str]:
    if isinstance(value, dict) and value:
        for key, below in value.items():
            yield from leaves(f"{path}.{key}".lstrip("."), below)
    elif path == "objects":
        for one in value[:3]:
            yield from leaves(path, one)
    elif isinstance(value, list) and value and all(isinstance(v, int | float | list) for v in value):
        for k, below in enumerate(value):
            yield from leaves(f"{path}.{k}", below)
    else:
        yield path


def test_every_key_of_the_table_is_one_that_answers_have(recording):
    keys = {key for _, call in recording.calls() for key in leaves("", {**call.metadata, "pictures": call.pictures})}
    patterns = {pattern.split(":")[1] for rule in RULES for pattern in rule.keys}
    assert not {pattern for pattern in patterns if not any(fnmatchcase(key, pattern) for key in keys)}


def call(**metadata) -> Call:
    return Call("step", {"action": "Pass"}, metadata, {})


def test_objects_are_compared_by_name_in_any_order():
    a, b = {"name": "A", "objectId": "A|1", "visible": True}, {"name": "B", "objectId": "B|1", "visible": True}
    assert not list(differences(2, call(objects=[a, b]), call(objects=[b, a])))
    (found,) = differences(2, call(objects=[a, b]), call(objects=[{**a, "visible": False}, b]))
    assert found == Difference(2, "Pass:objects.visible", True, False, None)
    (found,) = differences(2, call(objects=[a, b]), call(objects=[a]))
    assert found == Difference(2, "Pass:objects", "B", None, None)
    assert allowed(found, RULES) is None


def test_points_have_no_order_and_angles_go_round():
    points = [{"x": 1.0, "y": 0.9, "z": 0.0}, {"x": 0.0, "y": 0.9, "z": 0.0}]
    assert not list(differences(2, call(actionReturn=points), call(actionReturn=points[::-1])))
    (found,) = differences(2, call(actionReturn=points), call(actionReturn=points[:1]))
    assert found.by == 0.5 and found.key == "Pass:actionReturn"
    (found,) = differences(2, call(agent={"rotation": {"y": 359.99}}), call(agent={"rotation": {"y": 0.01}}))
    assert found.by == pytest.approx(0.02)


@pytest.mark.parametrize(("by", "may"), [(0.04, True), (0.06, False)])
def test_a_tolerance_ends_where_it_says(by, may):
    (found,) = differences(
        2, call(objects=[{"name": "A", "position": {"x": 0.0}}]), call(objects=[{"name": "A", "position": {"x": by}}])
    )
    assert (allowed(found, RULES) is not None) is may
    assert allowed(found, ()) is None


def test_masks_have_their_sizes_and_do_not_overlap():
    masks = Masks((10, 10), {"A|": 30, "B|": 70})
    assert {name: int(np.count_nonzero(mask)) for name, mask in masks.items()} == {"A|": 30, "B|": 70}
    assert not (masks["A|"] & masks["B|"]).any() and masks.mask("C|") is None
