"""Files of named arrays (.npz without pickles) with a schema and a digest of every array.

Equal content has equal bytes. A torn or changed file is refused in one line; none of its values is used.
"""

from __future__ import annotations

import hashlib
import io
import os
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

_SCHEMA, _DIGESTS = "schema", "digests"


class ArrayFileError(ValueError):
    """A file that is torn, changed or of another schema; one line with the file and the remedy."""

    says_all = True


def write_arrays(path: Path, schema: str, arrays: Mapping[str, np.ndarray], compressed: bool = False) -> None:
    """Write arrays with a schema and their digests, as numpy.savez does.

    Compression is at the fastest level, which numpy does not offer: in less than half of its time to 105 % of its size.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    method = zipfile.ZIP_DEFLATED if compressed else zipfile.ZIP_STORED
    members = {_SCHEMA: np.array(schema), **arrays}
    digests = np.array([(name, _digest(np.asanyarray(array))) for name, array in members.items()], str)
    with path.open("wb") as file:
        with zipfile.ZipFile(file, "w", method, compresslevel=1) as archive:
            for name, array in {**members, _DIGESTS: digests}.items():
                member = zipfile.ZipInfo(f"{name}.npy")
                member.compress_type = method
                with archive.open(member, "w", force_zip64=True) as to:
                    np.lib.format.write_array(to, np.asanyarray(array), allow_pickle=False)
        file.flush()
        os.fsync(file.fileno())


def read_arrays(path: Path, schema: str, skip: str | None = None) -> dict[str, np.ndarray]:
    """Read all arrays of a file but those whose name ends in `skip`.

    Raises:
        FileNotFoundError: The file is missing.
        ArrayFileError: The file is damaged or not of `schema`.
    """
    with _open(path) as archive:
        names = [Path(name).stem if name.endswith(".npy") else name for name in archive.namelist()]
        found = str(_read_array(archive, _SCHEMA)) if _SCHEMA in names else "nothing"
        if found != schema:
            raise ArrayFileError(f"{path}: schema is {found}, not {schema}; remove the file and make it again")
        wanted = [name for name in names if name not in (_SCHEMA, _DIGESTS) and not (skip is not None and name.endswith(skip))]
        arrays = {name: _read_array(archive, name) for name in wanted}
        digests = _read_digests(archive)
        if {*names} != {*digests, _DIGESTS}:
            raise ValueError("arrays are missing")
        for name, array in arrays.items():
            _verify(name, array, digests)
    return arrays


def read_array(path: Path, name: str) -> np.ndarray:
    """Read one array of a file. Raises as `read_arrays`."""
    with _open(path) as archive:
        array = _read_array(archive, name)
        _verify(name, array, _read_digests(archive))
    return array


@contextmanager
def _open(path: Path) -> Iterator[zipfile.ZipFile]:
    with path.open("rb") as file:
        try:
            with zipfile.ZipFile(file) as archive:
                yield archive
        except ArrayFileError:
            raise
        except Exception as error:  # a changed byte may be anything to zipfile and numpy: a wrong size, a method, a password
            why = " ".join(str(error).split()) or type(error).__name__
            raise ArrayFileError(f"{path}: not a readable .npz file ({why[:120]}); remove it and make it again") from None


def _read_array(archive: zipfile.ZipFile, name: str) -> np.ndarray:
    """Read an array; zipfile checks its CRC before numpy reads the header."""
    array: np.ndarray = np.lib.format.read_array(io.BytesIO(archive.read(f"{name}.npy")), allow_pickle=False)
    return array


def _read_digests(archive: zipfile.ZipFile) -> dict[str, str]:
    return dict(_read_array(archive, _DIGESTS).reshape(-1, 2).tolist())


def _verify(name: str, array: np.ndarray, digests: Mapping[str, str]) -> None:
    if digests.get(name) != _digest(array):
        raise ValueError(f"the digest of {name!r} is not that of its content")


def _digest(array: np.ndarray) -> str:
    """Return the BLAKE2b of an array's type, shape and values in C order."""
    found = hashlib.blake2b(f"{array.dtype.str} {array.shape}".encode(), digest_size=16)
    found.update(array.tobytes())
    return found.hexdigest()
