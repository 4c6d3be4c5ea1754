"""Files of arrays: what comes back is what was written, and a damaged file is refused in one line."""

from __future__ import annotations

import zipfile
from pathlib import Path

import numpy as np
import pytest

from ovman.agents.dualmap.observation_records import Taken, read_walks, write_walks
from ovman.agents.dualmap.shot import Shot
from ovman.evaluation.supervision import name_failures
from ovman.perception.array_file import ArrayFileError, read_array, read_arrays, write_arrays
from ovman.perception.records import read_maps, read_nouns, write_maps, write_nouns

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


def test_numpy_reads_it_too(file):
    with np.load(file) as archive:
        assert np.array_equal(archive["feature"], ARRAYS["feature"])


def test_a_flipped_byte_changes_nothing_or_is_one_line_with_the_file_and_the_remedy(file):
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


def test_a_file_that_is_cut_anywhere_is_refused(file):
    whole = file.read_bytes()
    for end in range(0, len(whole), 23):
        file.write_bytes(whole[:end])
        with pytest.raises(ArrayFileError, match="remove it and make it again"):
            read_arrays(file, SCHEMA)


def replaced(file: Path, name: str, array: np.ndarray | None) -> None:
    """The file with another array under a name, or without it; its CRC is right."""
    with zipfile.ZipFile(file) as archive:
        members = {member: archive.read(member) for member in archive.namelist() if member != f"{name}.npy"}
    with zipfile.ZipFile(file, "w") as archive:
        for member, content in members.items():
            archive.writestr(member, content)
        if array is not None:
            with archive.open(f"{name}.npy", "w") as to:
                np.lib.format.write_array(to, array)


def test_a_value_that_was_changed_with_its_checksum_is_noticed(file):
    changed = ARRAYS["feature"].copy()
    changed[2, 3] += 1e-3
    replaced(file, "feature", changed)
    with pytest.raises(ArrayFileError, match="the digest of 'feature' is not that of its content"):
        read_arrays(file, SCHEMA)
    replaced(file, "0.bits", ARRAYS["0.bits"] ^ 1)
    with pytest.raises(ArrayFileError, match="digest of '0.bits'"):
        read_array(file, "0.bits")


def test_an_array_that_is_missing_or_has_no_digest_is_noticed(file):
    replaced(file, "none", None)
    with pytest.raises(ArrayFileError, match="arrays are missing"):
        read_arrays(file, SCHEMA)
    replaced(file, "digests", None)
    with pytest.raises(ArrayFileError, match="digests"):
        read_arrays(file, SCHEMA)


def test_a_file_that_is_not_there_stays_a_missing_file(tmp_path):
    with pytest.raises(FileNotFoundError):
        read_arrays(tmp_path / "x.npz", SCHEMA)


@pytest.mark.parametrize("kind", ["maps", "nouns", "walks"])
def test_every_kind_of_file_is_checked(tmp_path, kind):
    path = tmp_path / f"{kind}.npz"
    if kind == "maps":
        write_maps(path, {"untouched": ()})
    elif kind == "nouns":
        write_nouns(path, {"chair": np.ones(3, np.float32)})
    else:
        write_walks(path, {"untouched": Taken(np.zeros(1, int), np.zeros(1, int))}, [Shot((), 2.5)], ["chair"], np.array([True]))
    whole, refused = path.read_bytes(), 0
    read = {"maps": read_maps, "nouns": read_nouns, "walks": read_walks}[kind]
    places = range(0, len(whole), 29)
    for place in places:
        path.write_bytes(whole[:place] + bytes([whole[place] ^ 1]) + whole[place + 1 :])
        try:
            read(path)
        except ArrayFileError:
            refused += 1
    assert refused > len(places) / 2


def test_a_damaged_file_is_not_blamed_on_the_agent_that_asked_for_it(file):
    file.write_bytes(b"PK")
    with pytest.raises(ArrayFileError, match="make it again") as caught, name_failures("arms.mine: it"):
        read_arrays(file, SCHEMA)
    assert caught.value.says_all and "mend the agent" not in str(caught.value)
