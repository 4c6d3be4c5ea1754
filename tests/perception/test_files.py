"""Files of arrays come back as they were written, and a damaged file is refused in one line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.evaluation.supervision import name_failures
from ovman.perception.array_file import ArrayFileError, read_array, read_arrays, write_arrays
from ovman.perception.clusters import Cluster
from ovman.perception.records import Detected, read_detections, read_maps, write_detections, write_maps, write_nouns

SCHEMA = "ovman-test/1"
ARRAYS = {
    "names": np.array(["chair", "TV stand"]),
    "feature": np.linspace(0, 1, 64).reshape(4, 16).astype(np.float32),
    "rows": np.asfortranarray(np.arange(12).reshape(3, 4)),
    "none": np.zeros((0, 3)),
    "0.bits": np.arange(200, dtype=np.uint8).reshape(2, 100),
    "count": np.array(7),
}


@pytest.fixture(params=[False, True], ids=["stored", "compressed"])
def file(tmp_path, request) -> Path:
    write_arrays(tmp_path / "x.npz", SCHEMA, ARRAYS, compressed=request.param)
    return tmp_path / "x.npz"


def assert_same(found: dict[str, np.ndarray]) -> None:
    assert list(found) == list(ARRAYS)
    for name, array in ARRAYS.items():
        assert np.array_equal(found[name], array) and found[name].dtype == array.dtype


def test_arrays_come_back_all_or_without_those_that_are_skipped(file):
    assert_same(read_arrays(file, SCHEMA))
    assert set(ARRAYS) - set(read_arrays(file, SCHEMA, skip=".bits")) == {"0.bits"}
    assert np.array_equal(read_array(file, "0.bits"), ARRAYS["0.bits"])


def test_a_damaged_file_reads_the_same_or_is_refused_in_one_line_with_the_remedy(file):
    whole, refused = file.read_bytes(), 0
    places = range(0, len(whole), 13)
    for place in places:
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        try:
            assert_same(read_arrays(file, SCHEMA))
        except ArrayFileError as error:
            refused += 1
            says = str(error)
            assert says.startswith(f"{file}: ") and "remove" in says and "make it again" in says
            assert "\n" not in says and len(says) < len(str(file)) + 250
    assert refused > len(places) / 2
    for end in range(0, len(whole), 23):
        file.write_bytes(whole[:end])
        with pytest.raises(ArrayFileError, match="remove it and make it again"):
            read_arrays(file, SCHEMA)


def test_a_damaged_file_is_not_blamed_on_the_agent_that_asked_for_it(file):
    file.write_bytes(b"PK")
    with pytest.raises(ArrayFileError, match="make it again") as caught, name_failures("arms.mine: it"):
        read_arrays(file, SCHEMA)
    assert caught.value.says_all and "mend the agent" not in str(caught.value)


FIELDS = ("view", "point", "feature", "pixels", "confidence")


def detected(rng: np.random.Generator, count: int, height: int = 5, width: int = 7) -> Detected:
    masks = rng.random((count, height, width)) < 0.4
    return Detected(
        view=np.sort(rng.integers(0, 24, count)),
        point=rng.normal(size=(count, 3)),
        feature=rng.normal(size=(count, 4)).astype(np.float32),
        pixels=masks.sum(axis=(1, 2)),
        confidence=rng.random(count).astype(np.float32),
        masks=lambda: masks,
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


@settings(max_examples=12)
@given(names=names, counts=st.lists(st.integers(0, 4), min_size=4, max_size=4), seed=st.integers(0, 99))
def test_detections_come_back_and_equal_ones_have_equal_bytes(tmp_path_factory, names, counts, seed):
    rng = np.random.default_rng(seed)
    visits = {name: detected(rng, count) for name, count in zip(names, counts, strict=False)}
    path, again = (tmp_path_factory.mktemp("d") / "d.npz" for _ in range(2))
    write_detections(path, visits)
    found = read_detections(path)
    assert list(found) == list(visits)
    for name, seen in visits.items():
        for array in FIELDS:
            assert np.array_equal(getattr(found[name], array), getattr(seen, array))
            assert getattr(found[name], array).dtype == getattr(seen, array).dtype
        assert found[name].content == seen.content and len(found[name]) == len(seen)
        assert np.array_equal(found[name].masks(), seen.masks()) and found[name].masks().shape == (len(seen), 5, 7)
    write_detections(again, found)
    assert again.read_bytes() == path.read_bytes()


@settings(max_examples=12)
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


def test_a_file_of_another_kind_is_one_line(tmp_path):
    path = tmp_path / "nouns.npz"
    write_nouns(path, {"chair": np.array([1.0], np.float32)})
    with pytest.raises(ArrayFileError, match="schema is ovman-nouns/2, not ovman-maps/3") as caught:
        read_maps(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


def test_a_pickle_in_an_archive_is_not_opened(tmp_path):
    path = tmp_path / "maps.npz"
    np.savez(path, schema=np.array("ovman-maps/3"), visits=np.array([{}], object))
    with pytest.raises(ArrayFileError, match="allow_pickle"):
        read_maps(path)
