"""The stage of the walks: frames of equal content are looked at once, and a killed job goes on where it was."""

from __future__ import annotations

import json
from types import SimpleNamespace

import numpy as np
import pytest

from ovman.agents.dualmap import walks
from ovman.agents.dualmap.observations import NO_VIEW, FrameObject, Shot, read_walks
from ovman.agents.dualmap.walks import Assigned, Memory
from ovman.cache import Cache
from ovman.perception.backprojection import Camera
from ovman.perception.labels import read_labels
from ovman.records.scene import Alteration
from ovman.records.visit import Visit
from ovman.sim.session import AgentPose
from ovman.sim.walk import Frame
from tests.arms import CONFIG
from tests.episodes import released

RUNS = 2


def frame(grey: int, view: int | None = None, x: float = 0.0) -> Frame:
    rgb, depth = np.full((4, 4, 3), grey, np.uint8), np.ones((4, 4), np.float32)
    # The left half of the frame shows a chair, the right half the shell of the room.
    numbers = np.where(np.arange(4) < 2, 3 | 2 << 8 | 1 << 16 | 255 << 24, 9).astype(np.uint32) * np.ones((4, 1), np.uint32)
    masks = SimpleNamespace(instance_segmentation_frame_uint32=numbers, instance_colors={"Chair|1": [3, 2, 1]})
    return Frame(rgb, depth, Camera((x, 1.0, 0.0), 0.0, 0.0, 90.0), AgentPose(x, 0.0, 0.0), view, masks)


def visit_of(name: str) -> Visit:
    gone = Alteration(kind="disable", instance=name)
    return Visit(scene="FloorPlan1", visit=name, alterations=(gone,), placed={}, present={}, movers=(), views=())


def clouds(frame, runs):
    return tuple(draws.random((frame.rgb[0, 0, 0], 3), np.float32) for draws in runs)


CEILING = FrameObject(0, np.eye(4, dtype=np.float32)[1], 0.5, (np.array([[0, 2.35, 0], [0, 2.4, 0]], np.float32),) * RUNS)


class Observer:
    """Sees one object in each frame, of as many points as it is grey, where the runs draw them, and a part of the ceiling.

    Its mask is the chair's where the frame's grey is even, else the shell's.
    """

    classes = ("chair", "cup")

    def __init__(self):
        self.looked_at = []

    def look(self, frames, draws):
        self.looked_at += [int(f.rgb[0, 0, 0]) for f in frames]
        return [
            (
                Shot((FrameObject(1, np.eye(4, dtype=np.float32)[0], 0.5, clouds(f, runs)), CEILING), 2.5),
                [(np.arange(4) < 2) == (f.rgb[0, 0, 0] % 2 == 0) & np.ones((4, 1), bool), np.ones((4, 4), bool)],
            )
            for f, runs in zip(frames, draws, strict=True)
        ]


def test_frames_of_equal_content_are_looked_at_once_and_drawn_alike_in_any_walk():
    observer = Observer()
    memory = Memory(lambda: observer, RUNS, 0)
    contents, views, new = memory.process([frame(5, 0), frame(6), frame(5), frame(6, 1)])
    assert observer.looked_at == [5, 6] and views == [0, NO_VIEW, NO_VIEW, 1]
    assert contents[0] == contents[2] != contents[1] == contents[3] and list(new) == contents[:2]
    memory.shots |= {key: shot for key, (shot, _) in new.items()}
    assert not memory.process([frame(6)])[2]
    assert len(memory.process([frame(6, x=1.0)])[2]) == 1
    other, _ = Memory(lambda: Observer(), RUNS, 0).process([frame(6)])[2][contents[1]]
    for a, b in zip(other.seen[0].clouds, new[contents[1]][0].seen[0].clouds, strict=True):
        assert np.array_equal(a, b)
    assert not np.array_equal(*other.seen[0].clouds)


@pytest.fixture
def job(monkeypatch, tmp_path):
    """A job of three visits on frames that are told; `job.walked` are those that were walked, `job.fail` names one that fails."""
    told = {"a": [frame(3, 0), frame(4)], "b": [frame(4, 0), frame(5)], "c": [frame(3, 0), frame(6, 1)]}
    state = SimpleNamespace(walked=[], fail=None, observer=Observer(), kept=tmp_path / "kept")

    def frames(session, of, turn_deg):
        state.walked.append(of.recorded.visit)
        yield told[of.recorded.visit][0]
        if state.fail == of.recorded.visit:
            raise KeyboardInterrupt
        yield from told[of.recorded.visit][1:]

    scene, episodes = tmp_path / "scenes.jsonl", tmp_path / "episodes.jsonl"
    chair = {"id": "Chair|1", "category": "Chair", "moveable": True, "pickupable": False, "receptacle": True, "parents": []}
    chair |= dict.fromkeys(("position", "size"), {"x": 1.0, "y": 1.0, "z": 1.0})
    record = {"schema": "ovman-scene/2", "scene": "FloorPlan1", "start": {"x": 0.0, "z": 0.0}, "floor_y": 0.0, "reachable": [],
              "components": [], "waypoints": [], "other_waypoints": [], "mobile": [], "objects": [chair]}  # fmt: skip
    scene.write_text(json.dumps(record))
    episodes.write_text(released()[0].model_copy(update={"id": "FloorPlan1/moved/0001", "scene": "FloorPlan1"}).to_line())

    def run(output, names="abc"):
        state.walked, state.observer = [], Observer()
        of = {n: Assigned(visit_of(n), released()[0]) for n in names}
        monkeypatch.setattr(walks, "assign_visits", lambda episodes, visits: of)
        folders = tmp_path / output, tmp_path / f"labels of {output}"
        walks.run([scene], episodes, tmp_path, CONFIG, Cache(state.kept), *folders)
        return tmp_path / output / "FloorPlan1.npz"

    monkeypatch.setattr(walks, "walk_frames", frames)
    monkeypatch.setattr(walks, "_observer", lambda perception, observation: state.observer)
    monkeypatch.setattr(walks.networks, "looked_at_by", lambda perception: {})
    state.run = run
    return state


def test_a_killed_job_goes_on_with_the_walk_that_it_was_in_and_writes_the_same(job, tmp_path):
    whole = job.run("whole")
    assert job.walked == ["a", "b", "c"] and job.observer.looked_at == [3, 4, 5, 6]
    for part in job.kept.rglob("*.npz"):
        part.unlink()
    job.fail = "b"
    with pytest.raises(KeyboardInterrupt):
        job.run("cut")
    job.fail = None
    again = job.run("again")
    assert job.walked == ["b", "c"] and job.observer.looked_at == [5, 6]
    assert again.read_bytes() == whole.read_bytes()
    labels = [read_labels(tmp_path / f"labels of {name}" / "FloorPlan1.npz") for name in ("whole", "again")]
    for made in labels:
        assert {name: one.category.tolist() for name, one in made.items()} == {"a": [-1, 0], "b": [0, -1], "c": [-1, 0]}
        assert all(one.categories == ("Chair",) and one.pixels.tolist() == [8, 8] for one in made.values())
    seen = {name: [[one.class_id for one in frame] for frame in frames] for name, frames in read_walks(whole).keyframes.items()}
    assert seen == dict.fromkeys("abc", [[1], [1]]), "without the ceiling"
    assert job.run("once more").read_bytes() == whole.read_bytes() and job.walked == []
    for part in job.kept.rglob("*.npz"):
        part.write_bytes(part.read_bytes()[:100])
    assert job.run("of torn ones").read_bytes() == whole.read_bytes() and job.walked == ["a", "b", "c"]


def test_a_kept_walk_that_builds_on_one_that_is_gone_is_walked_again(job):
    job.run("whole")
    read = read_walks(job.run("two", "bc"))
    assert job.walked == ["b", "c"] and job.observer.looked_at == [4, 5, 3, 6]
    assert [len(frames) for frames in read.keyframes.values()] == [2, 2]
