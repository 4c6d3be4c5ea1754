"""Tables of embedded phrases."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from ovman.perception.array_file import ArrayFileError, write_arrays
from ovman.perception.phrases import SCHEMA, Phrases, UnknownPhraseError

TABLE = Phrases(("chair", "house plant"), np.eye(2, 3, dtype=np.float32), "a" * 64, {"torch": "2"})


def test_a_table_is_read_as_it_was_written(tmp_path):
    TABLE.write(tmp_path / "one.npz")
    TABLE.write(tmp_path / "other.npz")
    assert (tmp_path / "one.npz").read_bytes() == (tmp_path / "other.npz").read_bytes()
    found = Phrases.read(tmp_path / "one.npz")
    assert (found.phrases, found.source, found.made) == (TABLE.phrases, TABLE.source, TABLE.made)
    assert np.array_equal(found.rows(["house plant", "chair", "chair"]), TABLE.feature[[1, 0, 0]])
    with pytest.raises(UnknownPhraseError, match=r"^sofa$"):
        found.rows(["chair", "sofa"])


@pytest.mark.parametrize("what", ["torn", "no source", "other numbers", "other kind"])
def test_a_file_that_is_no_table_is_refused_in_one_line(tmp_path: Path, what: str):
    path = tmp_path / "spoilt.npz"
    TABLE.write(path)
    if what == "torn":
        path.write_bytes(path.read_bytes()[:-40])
    elif what == "no source":
        write_arrays(path, SCHEMA, {"phrases": np.array(["a"]), "feature": np.zeros((1, 2), np.float32), "of": np.array("{}")})
    elif what == "other numbers":
        Phrases(("chair",), TABLE.feature, TABLE.source, {}).write(path)
    else:
        write_arrays(path, "ovman-maps/1", {"phrases": np.array(["a"])})
    with pytest.raises(ArrayFileError) as caught:
        Phrases.read(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
