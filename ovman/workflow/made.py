"""What made each output of a working directory: rule, parameter, inputs, digests. The release keeps it for `ovman restore`.

Parameters are those that Snakemake recorded when the outputs were made, never those of the checkout that reads them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import AfterValidator, TypeAdapter, ValidationError

from ovman.atomic import inner
from ovman.records.record import RecordError, complaint
from ovman.shipped import HOME
from ovman.workflow import checksums
from ovman.workflow.snakemake_records import Done, Records

PARAMETERS, JOBS = Path("parameters.json"), Path("made.jsonl")
"""The two files, in the release."""
TABLES = (checksums.MADE / "all").as_posix()


def is_result(name: str) -> bool:
    """Whether an input is an output of another rule; others lie in the checkout."""
    return Path(name).parts[:1] == checksums.MADE.parts


def _below_results(name: str) -> str:
    if not is_result(inner(name)) or len(Path(name).parts) < 2:
        raise ValueError(f"{name!r} is not a result; it must lie below {checksums.MADE}/")
    return name


Parsed = TypeVar("Parsed")
Inner = Annotated[str, AfterValidator(inner)]
Result = Annotated[str, AfterValidator(_below_results)]
Part = Annotated[str, AfterValidator(lambda name: name and inner(name))]
"""A file within an output, "" for the output itself."""


@dataclass(frozen=True)
class Made:
    """Outputs that were made alike. outputs: SHA-256 by name within a folder, "" for the output itself, by the output's path.

    parameter: its key. inputs: paths below the working directory, or below the checkout for files of the checkout; sorted.
    """

    rule: str
    parameter: str
    inputs: tuple[Inner, ...]
    outputs: Mapping[Result, Mapping[Part, str]]


@dataclass(frozen=True)
class _Shared:
    """The content of `PARAMETERS`: parameters by key, and SHA-256 of inputs that lie in the checkout."""

    parameters: Mapping[str, Any]
    sources: Mapping[Inner, str]


@dataclass(frozen=True)
class Making:
    """All of a working directory. parameters: canonical texts by key; sources: SHA-256 of inputs that lie in the checkout."""

    parameters: Mapping[str, str]
    sources: Mapping[str, str]
    jobs: Sequence[Made]

    def files(self) -> dict[str, str]:
        """SHA-256 of every file of every output by its path."""
        outputs = (pair for job in self.jobs for pair in job.outputs.items())
        return {(f"{place}/{name}" if name else place): sha for place, files in outputs for name, sha in files.items()}

    def digests(self) -> dict[str, str]:
        """SHA-256 of every output that is one file and of every input that lies in the checkout, by path."""
        outputs = (pair for job in self.jobs for pair in job.outputs.items())
        return {place: files[""] for place, files in outputs if "" in files} | dict(self.sources)


def key_of(parameter: str) -> str:
    """The key of a canonical text."""
    return hashlib.sha256(parameter.encode()).hexdigest()[:16]


def making(directory: Path, home: Path = HOME) -> Making:
    """What made the outputs of a working directory that lead to its tables, and those that were made with them.

    An output that was made and is no longer there is among them. The content of none is looked at: `checksums.damages` does.
    home: the checkout whose rules made them. ValueError, in one line, for an output that Snakemake has no record of, that was
    made from another input than the one that is known, or that another checkout made.
    """
    known = _known(directory)
    done = _leading(directory, known)
    parameters: dict[str, str] = {}
    sources: dict[str, str] = {}
    alike: dict[tuple[str, str, tuple[str, ...]], dict[str, Mapping[str, str]]] = {}
    for place, one in done.items():
        for name, digest in known[place].inputs.items():
            if name in known and known[name].files.get("", digest) != digest:
                raise ValueError(f"{place}: is stale, it was made from another {name}; {_again(place)}")
        inputs = tuple(sorted(_named(name, home, place) for name in one.inputs))
        for name in inputs:
            if not is_result(name) and name not in sources:
                sources[name] = checksums.digest_of(home / name)
        key = key_of(one.parameter)
        parameters[key] = one.parameter
        alike.setdefault((one.rule, key, inputs), {})[place] = known[place].files
    jobs = [Made(*how, dict(sorted(outputs.items()))) for how, outputs in sorted(alike.items())]
    return Making(dict(sorted(parameters.items())), dict(sorted(sources.items())), jobs)


def _known(directory: Path) -> dict[str, checksums.Checksums]:
    """The checksums of all outputs by path."""
    folder = directory / checksums.FOLDER
    paths = {checksums.MADE / path.relative_to(folder).with_suffix(""): path for path in sorted(folder.rglob("*.json"))}
    return {place.as_posix(): checksums.Checksums(**json.loads(path.read_bytes())) for place, path in paths.items()}


def _leading(directory: Path, known: Iterable[str]) -> dict[str, Done]:
    """Snakemake's records of the outputs that lead to the tables, and of all outputs of their jobs."""
    records = Records(directory)
    done = {place: one for place in known if (one := records.read(place)) is not None}
    together: dict[tuple[str, str], list[str]] = {}
    for place, one in done.items():
        together.setdefault((one.rule, one.log or place), []).append(place)
    found: dict[str, Done] = {}
    waiting = [TABLES]
    while waiting:
        place = waiting.pop()
        if place in found:
            continue
        if place not in done:
            raise ValueError(f"{place}: there is no record of what made it; {_again(place)}")
        for other in together[done[place].rule, done[place].log or place]:
            found[other] = done[other]
        waiting += filter(is_result, done[place].inputs)
    return dict(sorted(found.items()))


def _again(place: str) -> str:
    return f"make it again: snakemake --cores 2 --force -- {place}"


def _named(name: str, home: Path, output: str) -> str:
    """An input's path below the working directory or the checkout."""
    path = Path(name)
    if is_result(name):
        return name
    if not path.is_absolute() or not path.is_relative_to(home) or not path.is_file():
        raise ValueError(f"{output}: was made from {name}, which is no file of this checkout; make it again here: make tables")
    return path.relative_to(home).as_posix()


def write(made: Making, folder: Path) -> list[Path]:
    """Write what made the outputs into a folder; the files' names."""
    texts = {key: json.loads(text) for key, text in made.parameters.items()}
    parameters = json.dumps({"parameters": texts, "sources": made.sources}, indent=1, sort_keys=True)
    (folder / PARAMETERS).write_text(f"{parameters}\n", encoding="utf-8")
    lines = [json.dumps(vars(job), separators=(",", ":")) + "\n" for job in made.jobs]
    (folder / JOBS).write_text("".join(lines), encoding="utf-8")
    return [PARAMETERS, JOBS]


def read(folder: Path) -> Making:
    """What `write` wrote. FileNotFoundError where it is not there; ValueError, in one line, where it is not what was
    written, and for a name that leads out of results/ or of the checkout."""
    for name in (PARAMETERS, JOBS):
        if not (folder / name).is_file():
            raise FileNotFoundError(f"{folder / name} is not there: this release does not say what made it; take another")
    shared = _parse(TypeAdapter(_Shared), (folder / PARAMETERS).read_bytes(), str(folder / PARAMETERS))
    parameters = {key: json.dumps(one, sort_keys=True, separators=(",", ":")) for key, one in shared.parameters.items()}
    for key, text in parameters.items():
        if key_of(text) != key:
            raise ValueError(f"{folder / PARAMETERS}: the parameter {key} is not what was written; take the release anew")
    return Making(parameters, shared.sources, [*_jobs(folder / JOBS, parameters)])


def _jobs(path: Path, parameters: Mapping[str, str]) -> Iterator[Made]:
    adapter = TypeAdapter(Made)
    for number, line in enumerate(path.read_bytes().splitlines(), start=1):
        job = _parse(adapter, line, place := f"{path}:{number}")
        if job.parameter not in parameters:
            raise RecordError(f"{place}: parameter: {job.parameter!r} is not in {PARAMETERS}; take the release again")
        yield job


def _parse(of: TypeAdapter[Parsed], text: bytes, place: str) -> Parsed:
    """Return an object of a JSON text. RecordError, in one line, for another text and for a name that leads out of its folder."""
    try:
        return of.validate_json(text, strict=True)
    except ValidationError as error:
        raise RecordError(complaint(error, place)) from None


def done(made: Making, job: Made, digests: Mapping[str, str], home: Path = HOME) -> tuple[Done, dict[str, str]]:
    """A job as Snakemake knows it in a checkout, and the digests of its inputs by the names that it gives them.

    digests: those of `made`.
    """
    named = {name: name if is_result(name) else str(home / name) for name in job.inputs}
    known = {there: digests[name] for name, there in named.items() if name in digests}
    return Done(job.rule, made.parameters[job.parameter], tuple(named.values()), ""), known
