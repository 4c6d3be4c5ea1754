"""An archive of results, .tar.xz: the same bytes for the same files on every machine and day."""

from __future__ import annotations

import lzma
import tarfile
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import IO

from ovman.atomic import replacing

PRESET = 2
"""Of xz. Most of the bytes are features of networks, on which 6 gains a hundredth for three times the time."""

RATIO, ALLOWANCE = 100, 1 << 26
"""An archive unpacks to at most this many times its size, and 64 MiB. The released measurements unpack to 14 times theirs."""


def pack(directory: Path, names: Iterable[str], place: Path) -> None:
    """Write files, named relative to `directory`, to the archive `place`, which is replaced as a whole."""
    with (
        replacing(place) as partial,
        lzma.open(partial, "wb", preset=PRESET) as packed,
        tarfile.open(fileobj=packed, mode="w|", format=tarfile.GNU_FORMAT) as archive,
    ):
        for name in sorted(names):
            member = tarfile.TarInfo(name)
            member.size = (directory / name).stat().st_size
            with (directory / name).open("rb") as file:
                archive.addfile(member, file)


class _Bounded(lzma.LZMAFile):
    """An archive of which at most ALLOWANCE and RATIO times its size are read. ValueError, in one line, for more."""

    def __init__(self, place: Path) -> None:
        super().__init__(place)
        self._place, self._left = place, ALLOWANCE + RATIO * place.stat().st_size

    def read(self, size: int | None = -1) -> bytes:
        content = super().read(size)
        self._left -= len(content)
        if self._left < 0:
            raise ValueError(f"{self._place}: unpacks to more than {RATIO} times its size; take the archive again")
        return content


def unpack(place: Path, take: Callable[[str, IO[bytes]], None]) -> None:
    """Give name and content of an archive's files to `take`, in their order.

    ValueError, in one line, for a file that is no such archive, or that unpacks to more than RATIO times its size and ALLOWANCE.
    """
    try:
        with _Bounded(place) as packed, tarfile.open(fileobj=packed, mode="r|") as archive:
            for member in archive:
                content = None if member.issparse() else archive.extractfile(member)
                if content is None:
                    raise ValueError(f"{place}: {member.name} is no file; take the archive anew")
                take(member.name, content)
    except (tarfile.TarError, lzma.LZMAError, EOFError) as error:
        raise ValueError(f"{place}: is torn or no archive of results ({error}); take it anew") from None
