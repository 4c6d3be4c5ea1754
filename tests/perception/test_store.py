"""Detections that are kept by content."""

from __future__ import annotations

import os
import zipfile

import numpy as np
import pytest

from ovman.perception.array_file import read_arrays
from ovman.perception.records import DETECTIONS
from ovman.perception.store import Store
from ovman.processes import HOST
from tests.perception.test_records import detected

CONTENT = "ab" * 32


def some(content: str = CONTENT):
    found = detected(np.random.default_rng(0), 3)
    return type(found)(**{f: getattr(found, f) for f in found.__dataclass_fields__} | {"content": content})


def test_what_is_kept_is_not_looked_at_again(tmp_path):
    looks = []
    store = Store(tmp_path)
    first, known = store.kept(CONTENT, lambda: looks.append(1) or some())
    assert not known
    again, known = Store(tmp_path).kept(CONTENT, lambda: looks.append(1) or some())
    assert known and looks == [1]
    assert np.array_equal(first.masks(), again.masks()) and np.array_equal(first.point, again.point)


def test_a_look_that_fails_keeps_nothing(tmp_path):
    def fails():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        Store(tmp_path).kept(CONTENT, fails)
    assert [p for p in tmp_path.rglob("*") if p.is_file()] == []


def test_a_death_while_writing_leaves_the_place_free(tmp_path, monkeypatch):
    def dies(*_):
        raise SystemExit

    monkeypatch.setattr(os, "replace", dies)
    with pytest.raises(SystemExit):
        Store(tmp_path).kept(CONTENT, some)
    monkeypatch.undo()
    assert not list(tmp_path.rglob("*.npz"))
    assert Store(tmp_path).kept(CONTENT, some)[1] is False


@pytest.mark.parametrize("spoilt", [b"", b"PK half", None], ids=["empty", "half", "another content"])
def test_a_file_that_is_not_what_it_should_be_is_made_again(tmp_path, spoilt):
    store = Store(tmp_path)
    store.kept(CONTENT, some)
    (file,) = tmp_path.rglob("*.npz")
    if spoilt is None:
        store.kept("cd" * 32, lambda: some("cd" * 32))
        (other,) = (p for p in tmp_path.rglob("*.npz") if p != file)
        spoilt = other.read_bytes()
    file.write_bytes(spoilt)
    found, known = store.kept(CONTENT, some)
    assert not known and found.content == CONTENT
    assert store.kept(CONTENT, some)[1]


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5, 0.7, 0.9])
def test_a_flipped_byte_is_named_and_the_tour_is_looked_at_again(tmp_path, capsys, share):
    store = Store(tmp_path)
    whole, _ = store.kept(CONTENT, some)
    (file,) = tmp_path.rglob("*.npz")
    content = bytearray(file.read_bytes())
    content[int(share * len(content))] ^= 1
    file.write_bytes(content)
    capsys.readouterr()
    found, known = store.kept(CONTENT, some)
    (said,) = capsys.readouterr().out.splitlines() or [""]
    assert known is (said == "") and (known or said.startswith(str(file)))
    assert np.array_equal(found.masks(), whole.masks()) and np.array_equal(found.feature, whole.feature)
    assert store.kept(CONTENT, some)[1]


def test_flipped_masks_are_noticed(tmp_path, capsys):
    """Masks are read when they are asked for; what is kept is verified as a whole."""
    store = Store(tmp_path)
    store.kept(CONTENT, some)
    (file,) = tmp_path.rglob("*.npz")
    arrays = read_arrays(file, DETECTIONS)
    (masks,) = (name for name in arrays if name.endswith(".bits"))
    with zipfile.ZipFile(file) as archive:
        info = archive.getinfo(f"{masks}.npy")
        begin = file.read_bytes().index(f"{masks}.npy".encode()) + len(f"{masks}.npy")
    content = bytearray(file.read_bytes())
    content[begin + info.compress_size // 2] ^= 1
    file.write_bytes(content)
    assert store.kept(CONTENT, some)[1] is False
    assert str(file) in capsys.readouterr().out


def test_what_a_killed_process_left_goes_and_what_a_living_one_writes_stays(tmp_path):
    place = tmp_path / CONTENT[:2]
    place.mkdir()
    dead, living = (place / f".{CONTENT}.npz.{HOST}.{process}.partial" for process in (2**30, os.getppid()))
    for file in (dead, living):
        file.write_bytes(b"half")
    Store(tmp_path).kept(CONTENT, some)
    assert not dead.exists() and living.read_bytes() == b"half"
