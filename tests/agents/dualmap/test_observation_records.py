"""Observations of walks in files: what is read is what was written, to the millimetre, and equal content has equal bytes."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.agents.dualmap.observations import NO_VIEW, FrameObject, Shot, pack_shots, read_walks, unpack_shots, write_walks

NAMES, RUNS = ("chair", "sofa", "cup"), 3


def seen(rng) -> FrameObject:
    feature = rng.standard_normal(8).astype(np.float32)
    clouds = tuple(rng.uniform(-9, 9, (rng.integers(1, 60), 3)).astype(np.float32) for _ in range(RUNS))
    return FrameObject(int(rng.integers(3)), feature / np.linalg.norm(feature), float(np.float32(rng.random())), clouds)


def assert_same(read: FrameObject, written: FrameObject) -> None:
    assert read.class_id == written.class_id and read.confidence == pytest.approx(written.confidence)
    assert np.linalg.norm(read.feature) == pytest.approx(1.0, abs=1e-6)
    assert np.abs(read.feature - written.feature).max() < 1e-3
    for a, b in zip(read.clouds, written.clouds, strict=True):
        gaps = np.linalg.norm(a[:, None] - b[None], axis=2)
        assert a.dtype == np.float32 and len(a) == len(b)
        assert gaps.min(axis=1).max() < 1e-3 and gaps.min(axis=0).max() < 1e-3


def test_walks_come_back_frame_by_frame_to_the_millimetre_and_share_what_they_share(tmp_path):
    rng = np.random.default_rng(4)
    shots = [Shot(tuple(seen(rng) for _ in range(objects)), float(rng.random())) for objects in (3, 0, 1)]
    walks = {"untouched": ([0, 1, 2, 0], [0, NO_VIEW, 1, NO_VIEW]), "changed": ([2], [0]), "empty": ([], [])}
    again = unpack_shots(pack_shots(shots))
    assert [shot.top_m for shot in again] == [shot.top_m for shot in shots] and unpack_shots(pack_shots([])) == []
    once, twice = pack_shots(again), pack_shots(unpack_shots(pack_shots(again)))
    assert all(np.array_equal(once[name], twice[name]) for name in once), "what was read is written as it was"
    for name in ("a.npz", "b.npz"):
        write_walks(tmp_path / name, walks, shots, NAMES)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    read = read_walks(tmp_path / "a.npz")
    assert list(read.keyframes) == list(walks) and read.kinds == len(NAMES)
    assert read.keyframes["untouched"][0] is read.keyframes["untouched"][3]
    for name, (numbers, _) in walks.items():
        for number, frame in zip(numbers, read.keyframes[name], strict=True):
            for one, written in zip(frame, shots[number].seen, strict=True):
                assert_same(one, written)


def test_what_lies_too_far_away_is_refused():
    far = FrameObject(0, np.ones(1, np.float32), 0.5, (np.array([[40.0, 0, 0]], np.float32),))
    with pytest.raises(ValueError, match="no home is so large"):
        pack_shots([Shot((far,), 2.0)])
