"""`ovman restore`: the release's measurements put into results/, for Snakemake and the journals to go on from.

Every file is compared with the digest that was kept when its rule wrote it. Outputs that the release does not have get
Snakemake's record all the same: they are made where something that is to be made needs them, or where their own constants change.
"""

from __future__ import annotations

import functools
import json
import os
import shutil
import time
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import IO

from ovman.atomic import below, replacing
from ovman.report import archive, layout
from ovman.settings import Settings
from ovman.shipped import HOME
from ovman.workflow import checksums, made
from ovman.workflow.checksums import MADE, Checksums
from ovman.workflow.differences import differences
from ovman.workflow.made import Making
from ovman.workflow.snakemake_records import Records

STAMP = ".snakemake_timestamp"
"""By its time Snakemake tells when a folder was made."""
SUMS = Path("SHA256SUMS")


@dataclass(frozen=True)
class Restored:
    """What was put in place. files: of outputs. kept: of journals. absent: outputs that the release does not have, by rule."""

    files: int
    kept: int
    absent: Mapping[str, int]


def restore(release: Path, archives: Sequence[Path], directory: Path, settings: Settings | None, home: Path = HOME) -> Restored:
    """Put the results of a release and of further archives into `directory`/results, which is complete or absent.

    settings: those of this checkout, which the results must be of; None for results of any. home: this checkout.
    FileNotFoundError and ValueError, in one line: results are there already; a file is missing, or is not what was released;
    constants, code or another file of the checkout differ from those that the results were made with.
    """
    place = directory / MADE
    if place.exists() and any(place.iterdir()):
        raise ValueError(f"{place}: is there already; move it away, or restore into another folder with --directory")
    _check_sums(release, (made.PARAMETERS, made.JOBS, layout.MEASUREMENTS))
    making = made.read(release)
    if settings is not None:
        _check_same(making, settings, home)
    now = time.time_ns()
    with replacing(place) as partial:
        partial.mkdir(parents=True)
        files, kept = _fill(partial, making, release, archives)
        whole = _whole(making, files)
        _record(directory, partial, making, whole, home, now)
        for path in [partial, *partial.rglob("*")]:
            os.utime(path, ns=(now, now))
    absent = Counter(job.rule for job in making.jobs for output in job.outputs if output not in whole)
    return Restored(len(files), kept, absent)


def _check_sums(release: Path, names: Iterable[Path]) -> None:
    """ValueError for a file that is not what the release's checksums say."""
    path = release / SUMS
    if not path.is_file():
        raise FileNotFoundError(f"{path} is not there; give a release with --release")
    lines = (line.split("  ", 1) for line in path.read_text(encoding="utf-8").splitlines())
    sums = {name: sha for sha, name in lines}
    for name in names:
        if name.as_posix() not in sums or not (release / name).is_file():
            raise FileNotFoundError(f"{release / name} is not there: this release has not kept what made it; take a later one")
        if checksums.digest_of(release / name) != sums[name.as_posix()]:
            raise ValueError(f"{release / name}: has changed since it was released; take the release anew")


def _check_same(making: Making, settings: Settings, home: Path) -> None:
    """ValueError, in one line, where this checkout would make the results otherwise."""
    different = sorted(differences(making.parameters.values(), settings))
    for name, sha in making.sources.items():
        if not (home / name).is_file():
            different.append(f"{name}: is not there")
        elif checksums.digest_of(home / name) != sha:
            different.append(f"{name}: is another file")
    if different:
        more = f" (and {len(different) - 1} more)" if len(different) > 1 else ""
        remedy = "restore with the code and the settings of the release and change them then, or make all of it: make tables"
        raise ValueError(f"the release was made otherwise: {different[0]}{more}; {remedy}")


def _fill(partial: Path, making: Making, release: Path, archives: Sequence[Path]) -> tuple[set[str], int]:
    """Write all files that there are below `partial`; the outputs' files, and how many files of journals."""
    expected = making.files()
    files: set[str] = set()
    for name in expected:
        source = layout.released(name)
        if source is not None and (release / source).is_file():
            with (release / source).open("rb") as file:
                _write(partial, name, file, expected[name], release / source)
            files.add(name)
    journals: set[str] = set()

    def taken(path: Path, name: str, content: IO[bytes]) -> None:
        journal = path == release / layout.MEASUREMENTS and layout.within(name, layout.JOURNALS) and ".." not in Path(name).parts
        if name not in expected and not journal:
            raise ValueError(f"{path}: {name} is no result of {release}; give the archive of this release")
        _write(partial, name, content, expected.get(name), f"{path}: {name}")
        (journals if journal else files).add(name)

    for path in (release / layout.MEASUREMENTS, *archives):
        if not path.is_file():
            raise FileNotFoundError(f"{path} is not there")
        archive.unpack(path, functools.partial(taken, path))
    return files, len(journals)


def _write(partial: Path, name: str, content: IO[bytes], expected: str | None, source: object) -> None:
    """Write a file of results/ below `partial`. ValueError where its content is not the expected."""
    target = below(partial, _below(name))
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.open("wb") as file:
        shutil.copyfileobj(content, file)
    if expected is not None and checksums.digest_of(target) != expected:
        raise ValueError(f"{source}: is not what its rule wrote; take the release anew")


def _below(result: str | Path) -> str:
    """Return the path of a result without results/."""
    return Path(result).relative_to(MADE).as_posix()


def _whole(making: Making, files: set[str]) -> dict[str, Mapping[str, str]]:
    """The outputs all of whose files are there. ValueError for one of which some are."""
    whole = {}
    for job in making.jobs:
        for output, names in job.outputs.items():
            paths = {f"{output}/{name}" if name else output for name in names}
            if paths <= files:
                whole[output] = names
            elif paths & files:
                raise FileNotFoundError(f"{min(paths - files)}: is missing in the release; take it anew")
    return whole


def _record(directory: Path, partial: Path, making: Making, whole: Mapping[str, Mapping[str, str]], home: Path, now: int) -> None:
    """Keep checksums of what is there, and Snakemake's records of all."""
    records, known = Records(directory), making.digests()
    for job in making.jobs:
        done, digests = made.done(making, job, known, home)
        of_results = {name: sha for name, sha in digests.items() if name in whole}
        for output, names in job.outputs.items():
            records.write(output, done, now / 1e9, digests)
            if output in whole:
                if "" not in names:
                    (below(partial, _below(output)) / STAMP).touch()
                path = below(partial, _below(checksums.path_of(Path(output))))
                path.parent.mkdir(parents=True, exist_ok=True)
                text = json.dumps(asdict(Checksums(job.rule, names, of_results)), separators=(",", ":"))
                path.write_text(f"{text}\n", encoding="utf-8")
