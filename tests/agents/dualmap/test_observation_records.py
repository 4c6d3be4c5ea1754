"""Observations of walks in files: what is read is what was written, to the millimetre, and equal content has equal bytes."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.dualmap.observations import (
    NO_VIEW,
    FrameObject,
    Shot,
    pack_shots,
    read_walks,
    unpack_shots,
    write_walks,
)

NAMES = ("chair", "sofa", "cup")


def shot(rng, objects: int, runs: int = 3) -> Shot:
    def seen() -> FrameObject:
        feature = rng.standard_normal(8).astype(np.float32)
        clouds = tuple(rng.uniform(-9, 9, (rng.integers(1, 60), 3)).astype(np.float32) for _ in range(runs))
        return FrameObject(
            int(rng.integers(len(NAMES))), feature / np.linalg.norm(feature), float(np.float32(rng.random())), clouds
        )

    return Shot(tuple(seen() for _ in range(objects)), float(rng.random()))


@pytest.fixture
def shots():
    rng = np.random.default_rng(4)
    return [shot(rng, objects) for objects in (3, 0, 1)]


def assert_same(read: FrameObject, written: FrameObject) -> None:
    assert read.class_id == written.class_id and read.confidence == pytest.approx(written.confidence)
    assert np.linalg.norm(read.feature) == pytest.approx(1.0, abs=1e-6)
    assert np.abs(read.feature - written.feature).max() < 1e-3
    for a, b in zip(read.clouds, written.clouds, strict=True):
        assert a.dtype == np.float32 and len(a) == len(b)
        assert np.abs(np.sort(a, axis=0) - np.sort(b, axis=0)).max() <= 5.1e-4
        gaps = np.linalg.norm(a[:, None] - b[None], axis=2)
        assert gaps.min(axis=1).max() < 1e-3 and gaps.min(axis=0).max() < 1e-3


def test_shots_come_back_to_the_millimetre_and_stay_as_they_are_then(shots):
    read = unpack_shots(pack_shots(shots))
    for one, other in zip(read, shots, strict=True):
        assert one.top_m == other.top_m
        for a, b in zip(one.seen, other.seen, strict=True):
            assert_same(a, b)
    once, twice = pack_shots(read), pack_shots(unpack_shots(pack_shots(read)))
    assert all(np.array_equal(once[name], twice[name]) for name in once)
    assert unpack_shots(pack_shots([])) == []


def test_walks_come_back_frame_by_frame_and_share_what_they_share(shots, tmp_path):
    walks = {
        "untouched": ([0, 1, 2, 0], [0, NO_VIEW, 1, NO_VIEW]),
        "changed": ([2], [0]),
        "empty": ([], []),
    }
    for name in ("a.npz", "b.npz"):
        write_walks(tmp_path / name, walks, shots, NAMES)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    read = read_walks(tmp_path / "a.npz")
    assert list(read.keyframes) == list(walks)
    frames = read.keyframes["untouched"]
    assert [len(frame) for frame in frames] == [3, 0, 1, 3] and frames[0] is frames[3]
    assert len(read.keyframes["changed"]) == 1 and read.keyframes["empty"] == [] and read.kinds == len(NAMES)
    for number, frame in zip(walks["untouched"][0], frames, strict=True):
        for one, written in zip(frame, shots[number].seen, strict=True):
            assert_same(one, written)


def test_what_lies_too_far_away_is_refused():
    far = FrameObject(0, np.ones(1, np.float32), 0.5, (np.array([[40.0, 0, 0]], np.float32),))
    with pytest.raises(ValueError, match="no home is so large"):
        pack_shots([Shot((far,), 2.0)])
