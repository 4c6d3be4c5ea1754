"""SHA-256 of every output of the workflow, kept beside the results, so that a changed file is noticed where it is read.

`results/checksums/` has one small JSON file an output: the rule that wrote it, the digests of its files, and the digests of the
results that it was made from. A job compares its inputs with theirs before it begins; `ovman check` compares all of them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass
from pathlib import Path

from ovman.atomic import replace_bytes

FOLDER = Path("results", "checksums")
"""In the working directory; below it the paths of the outputs, with `.json` behind them."""
MADE = Path("results")


class ChangedError(ValueError):
    """A result is not what its rule wrote; one line: the file, what is wrong, and the command that makes it again."""

    says_all = True


@dataclass(frozen=True)
class Checksums:
    """What is known of an output. files: digests by name within a folder, "" for the output itself; inputs: digests by path."""

    rule: str
    files: Mapping[str, str]
    inputs: Mapping[str, str]


@dataclass(frozen=True)
class Damage:
    """An output that cannot be trusted. path: relative to the working directory."""

    path: Path
    problem: str

    def __str__(self) -> str:
        command = f"snakemake --cores 2 --force -- {self.path}"
        return f"{self.path}: {self.problem}; make it again: {command}"


def path_of(place: Path) -> Path:
    """Where the checksums of an output are. place: relative to the working directory, below results/."""
    below = place.relative_to(MADE)
    return FOLDER / below.with_name(f"{below.name}.json")


def digest_of(place: Path) -> str:
    """Hexadecimal SHA-256 of a file, or of the names and contents of a folder's files."""
    return _combined(_files(place))


def _combined(files: Mapping[str, str]) -> str:
    """One digest of the digests of an output's files; that of the output itself where it is a file."""
    if files.keys() == {""}:
        return files[""]
    return hashlib.sha256(json.dumps(sorted(files.items())).encode()).hexdigest()


def record(place: Path, rule: str, inputs: Mapping[str, str]) -> None:
    """Keep the checksums of an output that the job of `rule` has just made; nothing for one outside results/.

    place: relative to the working directory. inputs: what `verified` returned.
    """
    if _within_results(place):
        text = json.dumps(asdict(Checksums(rule, _files(place), inputs)), separators=(",", ":"))
        replace_bytes(path_of(place), text.encode() + b"\n")


def verified(inputs: Iterable[str]) -> dict[str, str]:
    """Digests by path of those inputs that are results. ChangedError for one that is not what its rule wrote."""
    digests = {}
    for name in inputs:
        place = Path(name)
        if not _within_results(place):
            continue
        found = _files(place) if place.exists() else None
        if damage := _changed(Path(), place, found):
            raise ChangedError(str(damage))
        if found is not None:
            digests[name] = _combined(found)
    return digests


def damages(directory: Path) -> Iterator[Damage]:
    """Every output below a working directory that is missing, changed, or made from other inputs than those that are there."""
    known: dict[str, str] = {}
    for path in sorted((directory / FOLDER).rglob("*.json")):
        place = MADE / path.relative_to(directory / FOLDER).with_suffix("")
        there = directory / place
        if damage := _changed(directory, place, _files(there) if there.exists() else None):
            yield damage
            continue
        for name, digest in _read(directory, place).inputs.items():
            there = directory / name
            if name not in known:
                known[name] = digest_of(there) if there.exists() else ""
            if known[name] != digest:
                yield Damage(place, f"is stale, it was made from another {name}")
                break


def _changed(directory: Path, place: Path, found: Mapping[str, str] | None) -> Damage | None:
    """What is wrong with an output. found: the digests of its files, which are read once; None where it is missing."""
    if not (directory / path_of(place)).exists():
        return None
    try:
        expected = _read(directory, place)
    except (ValueError, TypeError):
        return Damage(place, f"its checksums in {path_of(place)} are torn")
    if found is None:
        return Damage(place, "is missing")
    if found == expected.files:
        return None
    which = next(name for name in sorted({*found, *expected.files}) if found.get(name) != expected.files.get(name))
    what = f"{which} in it is missing" if which not in found else f"{which} in it has changed" if which else "has changed"
    return Damage(place, f"{what} since the rule {expected.rule} wrote it")


def _read(directory: Path, place: Path) -> Checksums:
    return Checksums(**json.loads((directory / path_of(place)).read_bytes()))


def _within_results(place: Path) -> bool:
    return not place.is_absolute() and place.parts[:1] == MADE.parts and len(place.parts) > 1


def _files(place: Path) -> dict[str, str]:
    """Digests of the files of an output. Hidden files, such as Snakemake's time stamp, do not count."""
    if not place.is_dir():
        return {"": _sha256(place)}
    files = (path for path in sorted(place.rglob("*")) if path.is_file() and not path.name.startswith("."))
    return {path.relative_to(place).as_posix(): _sha256(path) for path in files}


def _sha256(path: Path) -> str:
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()
