"""Files of named arrays (.npz without pickles) with a schema.

Equal content has equal bytes. A torn or changed file is refused in one line; none of its values is used.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import numpy as np

_SCHEMA = "schema"
"""Name of the array that has the schema and the names of all others."""


class ArrayFileError(ValueError):
    """A file that is torn, changed or of another schema; one line with the file and the remedy."""

    says_all = True


def write_arrays(path: Path, schema: str, arrays: Mapping[str, np.ndarray], compressed: bool = False) -> None:
    """Write arrays with a schema and their names, as numpy.savez does."""
    path.parent.mkdir(parents=True, exist_ok=True)
    save = np.savez_compressed if compressed else np.savez
    with path.open("wb") as file:  # numpy would add ".npz" to a name
        save(file, allow_pickle=False, **{_SCHEMA: np.array([schema, *arrays]), **arrays})


def read_arrays(path: Path, schema: str, skip: str | None = None) -> dict[str, np.ndarray]:
    """Read all arrays of a file but those whose name ends in `skip`.

    Raises:
        FileNotFoundError: The file is missing.
        ArrayFileError: The file is damaged or not of `schema`.
    """
    with _open(path) as archive:
        found, *names = np.atleast_1d(archive[_SCHEMA]).tolist() if _SCHEMA in archive else ["nothing"]
        if found != schema:
            raise ArrayFileError(f"{path}: schema is {found}, not {schema}; remove the file and make it again")
        names = names or [name for name in archive if name not in (_SCHEMA, "digests")]  # of a file of OVMAN 0.11
        return {name: archive[name] for name in names if skip is None or not name.endswith(skip)}


def read_array(path: Path, name: str) -> np.ndarray:
    """Read one array of a file. Raises as `read_arrays`."""
    with _open(path) as archive:
        return archive[name]


@contextmanager
def _open(path: Path) -> Iterator[Mapping[str, np.ndarray]]:
    with path.open("rb") as file:
        try:
            with np.load(file, allow_pickle=False) as archive:
                yield archive
        except ArrayFileError:
            raise
        except Exception as error:  # a changed byte may be anything to zipfile and numpy: a wrong size, a method, a password
            why = " ".join(str(error).split()) or type(error).__name__
            raise ArrayFileError(f"{path}: not a readable .npz file ({why[:120]}); remove it and make it again") from None
