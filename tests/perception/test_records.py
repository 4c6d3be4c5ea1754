"""Files of detections, maps and nouns."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.perception.array_file import ArrayFileError
from ovman.perception.clusters import Cluster
from ovman.perception.detected import Detected, PackedMasks
from ovman.perception.records import (
    read_detections,
    read_maps,
    read_nouns,
    write_detections,
    write_maps,
    write_nouns,
)

ARRAYS = ("view", "point", "feature", "pixels", "confidence")


def detected(rng: np.random.Generator, count: int, height: int = 5, width: int = 7) -> Detected:
    masks = rng.random((count, height, width)) < 0.4
    return Detected(
        view=np.sort(rng.integers(0, 24, count)),
        point=rng.normal(size=(count, 3)),
        feature=rng.normal(size=(count, 4)).astype(np.float32),
        pixels=masks.sum(axis=(1, 2)),
        confidence=rng.random(count).astype(np.float32),
        packed=PackedMasks.of(masks),
        content=f"{rng.integers(2**40):x}",
    )


def cluster(rng: np.random.Generator, length: int) -> Cluster:
    return Cluster(
        rng.normal(size=2),
        rng.normal(size=4).astype(np.float32),
        rng.normal(size=(length, 2)),
        np.sort(rng.integers(0, 24, length)),
    )


names = st.lists(st.text(st.characters(codec="utf-8", exclude_characters="\0"), min_size=1, max_size=5), unique=True, max_size=4)


@settings(derandomize=True, max_examples=25, deadline=None)
@given(names=names, counts=st.lists(st.integers(0, 4), min_size=4, max_size=4), seed=st.integers(0, 99))
def test_detections_come_back_and_equal_ones_have_equal_bytes(tmp_path_factory, names, counts, seed):
    rng = np.random.default_rng(seed)
    visits = {name: detected(rng, count) for name, count in zip(names, counts, strict=False)}
    path, again = (tmp_path_factory.mktemp("d") / "d.npz" for _ in range(2))
    write_detections(path, visits)
    found = read_detections(path)
    assert list(found) == list(visits)
    for name, seen in visits.items():
        for array in ARRAYS:
            assert np.array_equal(getattr(found[name], array), getattr(seen, array))
            assert getattr(found[name], array).dtype == getattr(seen, array).dtype
        assert found[name].content == seen.content and len(found[name]) == len(seen)
        assert np.array_equal(found[name].masks(), seen.masks()) and found[name].masks().shape == (len(seen), 5, 7)
    write_detections(again, found)
    assert again.read_bytes() == path.read_bytes()


@settings(derandomize=True, max_examples=25, deadline=None)
@given(names=names, lengths=st.lists(st.lists(st.integers(1, 5), max_size=3), min_size=4, max_size=4), seed=st.integers(0, 99))
def test_maps_come_back(tmp_path_factory, names, lengths, seed):
    rng = np.random.default_rng(seed)
    maps = {name: tuple(cluster(rng, n) for n in inner) for name, inner in zip(names, lengths, strict=False)}
    path = tmp_path_factory.mktemp("m") / "m.npz"
    write_maps(path, maps)
    found = read_maps(path)
    assert list(found) == list(maps)
    for name, clusters in maps.items():
        assert len(found[name]) == len(clusters)
        for there, here in zip(found[name], clusters, strict=True):
            for array in ("position", "feature", "track", "views"):
                assert np.array_equal(getattr(there, array), getattr(here, array)), array


def test_nouns_come_back(tmp_path):
    nouns = {"armchair": np.array([1.0, 0.0], np.float32), "TV stand": np.array([0.0, 1.0], np.float32)}
    write_nouns(tmp_path / "nouns.npz", nouns)
    found = read_nouns(tmp_path / "nouns.npz")
    assert list(found) == list(nouns) and all(np.array_equal(found[name], nouns[name]) for name in nouns)


def test_masks_that_fill_no_whole_byte():
    masks = np.random.default_rng(0).random((3, 3, 3)) < 0.5
    packed = PackedMasks.of(masks)
    assert packed.bits().shape == (3, 2) and np.array_equal(packed.unpacked(), masks)


def test_a_file_of_another_kind_is_one_line(tmp_path):
    path = tmp_path / "nouns.npz"
    write_nouns(path, {"chair": np.array([1.0], np.float32)})
    with pytest.raises(ArrayFileError, match="schema is ovman-nouns/2, not ovman-maps/3") as caught:
        read_maps(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [b"", b"text", b"PK\x03\x04 half a file"], ids=["empty", "text", "half"])
def test_a_file_that_is_no_archive_is_one_line(tmp_path, content):
    path = tmp_path / "maps.npz"
    path.write_bytes(content)
    with pytest.raises(ArrayFileError, match="remove it and make it again") as caught:
        read_maps(path)
    assert "\n" not in str(caught.value)


def test_a_pickle_in_an_archive_is_not_opened(tmp_path):
    path = tmp_path / "maps.npz"
    np.savez(path, schema=np.array("ovman-maps/3"), visits=np.array([{}], object))
    with pytest.raises(ArrayFileError, match="allow_pickle"):
        read_maps(path)
