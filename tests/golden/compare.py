"""Compare the contents of results with released or frozen ones: `make golden`, `make golden SIZE=tiny` or `SIZE=scene`.

Results are rows by stage: the lines of a JSONL file, the records of a CSV file, the lines of a printed table. Neither their order
nor the files that have them matter, except in printed tables. Arrays and pictures count as sets of rows.

`--freeze CHECKOUT` makes the reference of a size anew with the code of another checkout, which has a .venv of its own.
"""

from __future__ import annotations

import argparse
import csv
import gzip
import hashlib
import json
import os
import resource
import subprocess
import sys
import tempfile
from collections import Counter, defaultdict
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
SHOWN = 20
"""Differences that are printed."""
STAGES = (
    *("scenes", "candidates", "trials", "admissible", "certified", "episodes", "readmitted", "visits", "walks", "nouns"),
    *("detections", "maps", "segments", "labels", "walk_labels", "dualmap", "language"),
    *("predictions", "rollouts", "scores", "metrics", "tables", "all"),
)
"""First folders below results/ that are compared. `maintained` is left out: it covers fewer tours than in 0.11.0."""
BY_FILE = ("readmitted", "language", "metrics", "tables", "all")
"""Stages whose files differ in kind: their rows are compared by file."""
OF_EVERY_SPLIT = ("static_outcomes", "static_rates", "embodied_outcomes", "embodied_rates", "rejections")
"""Metrics that the release has of every split."""
RENAMED = {"sightings": "episodes"}
"""Folders whose rows were in those of another one in 0.11.0."""
SHARED = ("scenes", "visits")
"""Stages whose rows several splits may have: each row counts once."""
LEFT_OUT = {"content", "digests", "schema", "setting", "low_mobility"}
"""Fields and arrays about code and layout, and one that only a deleted map of DualMap read."""
TARGETS = {"tiny": ["results/all", "results/tables"], "scene": ["results/all", "results/tables"]}
COMMAND = ("snakemake", "--cores", "2", "--quiet", "all", "--configfile")

Rows = dict[str, Counter[str]]
"""By stage, canonical JSON of rows and how many there are."""


def main() -> int:
    """Run one size and return the exit status."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("size", nargs="?", default="pure", choices=("pure", *TARGETS))
    parser.add_argument("--freeze", type=Path, metavar="CHECKOUT", help="make the reference anew with the code of this checkout")
    parser.add_argument("--results", type=Path, help="compare this results folder instead of a new run")
    options = parser.parse_args()
    if options.size == "pure":
        return freeze() if options.freeze else pure()
    checkout = (options.freeze or ROOT).resolve()
    with tempfile.TemporaryDirectory() as directory:
        seconds = 0.0 if options.results else run(checkout, options.size, Path(directory))
        found = rows_of(options.results or Path(directory, "results"))
    path = HERE / f"{options.size}.json.gz"
    if options.freeze:
        write(path, {"cpu_seconds": round(seconds), "rows": {stage: sorted(rows.elements()) for stage, rows in found.items()}})
        return 0
    reference = read(path)
    if not options.results:
        share = seconds / reference["cpu_seconds"]
        print(f"{seconds:.0f} s of a processor; the reference took {reference['cpu_seconds']} s: {share:.2f} of it")
    return report({stage: Counter(rows) for stage, rows in reference["rows"].items()}, found)


def run(checkout: Path, size: str, directory: Path) -> float:
    """Run the workflow with an overlay to its end and return the seconds of processor time that it took."""
    overlay = checkout / "overlays" / "tiny.yaml" if size == "tiny" else HERE / f"{size}.yaml"
    environment = {**os.environ, "PATH": f"{checkout / '.venv' / 'bin'}{os.pathsep}{os.environ['PATH']}"}
    arguments = [*COMMAND, str(overlay), "--directory", str(directory), "--snakefile", str(checkout / "Snakefile")]
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*arguments, "--", *TARGETS[size]], check=True, cwd=checkout, env=environment)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def pure() -> int:
    """Recompute what follows from the released records, the parser's answers and the random streams."""
    frozen = read(HERE / "answers.json.gz")
    found, wanted, answers = recomputed(frozen)
    for name, rows in answers.items():
        wanted[name] = Counter(canonical({"asked": key, "answer": value}) for key, value in frozen[name].items())
        found[name] = Counter(canonical({"asked": key, "answer": value}) for key, value in rows.items())
    return report({key: wanted[key] for key in (*frozen["made"], *answers)}, found)


def recomputed(asked: Mapping[str, Any]) -> tuple[Rows, Rows, dict[str, dict[str, Any]]]:
    """Return the rows made here, the released ones, and the answers to what is asked."""
    from tests.golden import pure as stages

    with tempfile.TemporaryDirectory() as directory:
        given, made = stages.unpack(Path(directory, "given")), Path(directory, "results")
        stages.recompute(given, made)
        answers = {
            "parser": {sentence: stages.answer(sentence) for sentence in asked["parser"]},
            "streams": {name: stages.draws(*json.loads(name)) for name in asked["streams"]},
            "withheld": stages.withheld_queries(given),
        }
        return rows_of(made), rows_of(given), answers


def freeze() -> int:
    """Keep which stages are recomputed, the parser's answers and the random streams as they are in this checkout."""
    found, _, answers = recomputed(read(HERE / "answers.json.gz"))
    write(HERE / "answers.json.gz", {"made": sorted(found), **answers})
    return 0


def rows_of(results: Path) -> Rows:
    """Read the rows of everything below a results folder that is compared."""
    rows: Rows = defaultdict(Counter)
    arrays: dict[tuple[str, str], set[bytes]] = defaultdict(set)
    for path in sorted(results.rglob("*.*")):
        name = path.relative_to(results)
        stage = RENAMED.get(name.parts[0], name.parts[0].removesuffix(".npz"))
        if stage == "visits" and len(name.parts) == 2:  # the manifests of recorded tours
            continue
        if stage not in STAGES or path.is_dir() or path.name.startswith("."):
            continue
        if stage in BY_FILE:
            stage = "readmitted maps" if path.suffix == ".npz" else released_name(name) or ""
            if not stage:
                continue
        for kind, digests in arrays_of(path):
            arrays[stage, kind] |= digests
        rows[stage].update(canonical(row) for row in records_of(path))
    for stage in SHARED:
        rows[stage] = Counter(dict.fromkeys(rows[stage], 1))
    for (stage, kind), digests in arrays.items():
        digest = hashlib.sha256(b"".join(sorted(digests))).hexdigest()[:16]
        rows[stage][canonical({"array": kind, "rows": len(digests), "digest": digest})] += 1
    return {stage: found for stage, found in rows.items() if found}


def released_name(name: Path) -> str | None:
    """Return the name of a file in the release: its metrics of a split have the split in their names, those of main do not.

    The release has fewer metrics of the other splits; None for a file that it lacks.
    """
    if name.parts[0] != "metrics" or len(name.parts) < 3 or name.parts[1] in ("main", "paper"):
        return name.as_posix().replace("metrics/main/", "metrics/")
    if name.stem not in OF_EVERY_SPLIT:
        return None
    return f"metrics/{name.parts[1]}_{name.name.removeprefix('static_')}"


def records_of(path: Path) -> Iterator[Any]:
    """The records of a file; none of one that holds arrays."""
    printed = path.parts[-2] in ("tables", "all")
    match path.suffix:
        case ".jsonl":
            yield from map(json.loads, path.read_text(encoding="utf-8").splitlines())
        case ".json" if path.name == "visit.json" or path.parent.name == "scenes":
            yield json.loads(path.read_text(encoding="utf-8"))
        case ".csv":
            with path.open(encoding="utf-8", newline="") as file:
                rows = csv.DictReader(file)
                yield from ({"line": number, **row} if printed else row for number, row in enumerate(rows))
        case ".md" | ".tex":
            lines = path.read_text(encoding="utf-8").splitlines()
            yield from ({"line": number, "text": line} for number, line in enumerate(lines, 1))


def arrays_of(path: Path) -> Iterator[tuple[str, set[bytes]]]:
    """The arrays of a file as sets of digests of their rows, by name without the number of a visit."""
    if path.suffix == ".png":
        with Image.open(path) as picture:
            yield "pictures", {hashlib.sha256(np.asarray(picture).tobytes()).digest()}
    elif path.suffix == ".npz":
        with np.load(path, allow_pickle=False) as archive:
            for name in archive.files:
                kind = name.lstrip("0123456789.")
                if kind not in LEFT_OUT:
                    array = np.atleast_1d(archive[name])
                    text = array.dtype.kind == "U"  # the bytes of text depend on the longest one
                    rows = (repr(row.tolist()).encode() if text else row.tobytes() for row in array)
                    yield f"{kind} {array.dtype.kind}", {hashlib.sha256(row).digest() for row in rows}


def canonical(record: Any) -> str:
    """JSON with sorted keys, without the fields that are left out."""

    def kept(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: kept(one) for key, one in value.items() if key not in LEFT_OUT}
        return [kept(one) for one in value] if isinstance(value, list) else value

    return json.dumps(kept(record), sort_keys=True, separators=(",", ":"), ensure_ascii=False)


def report(wanted: Rows, found: Rows) -> int:
    """Print how the rows differ and return the exit status."""
    lines: list[str] = []
    for stage in sorted({*wanted, *found}):
        lost = wanted.get(stage, Counter()) - found.get(stage, Counter())
        gained = found.get(stage, Counter()) - wanted.get(stage, Counter())
        lines += [f"{stage}: {line}" for line in paired(list(lost.elements()), list(gained.elements()))]
    count = sum(map(Counter.total, wanted.values()))
    for line in lines[:SHOWN]:
        print(line[:400])
    print(
        f"{len(lines)} of {count} rows in {len(wanted)} stages differ"
        if lines
        else f"{count} rows in {len(wanted)} stages are equal"
    )
    return 1 if lines else 0


def paired(lost: list[str], gained: list[str]) -> Iterator[str]:
    """A line for each row that is lost or gained, a lost one with the gained one that is most like it."""
    fields = [dict(leaves(json.loads(row))) for row in gained[:2000]]
    for number, row in enumerate(lost):
        was = dict(leaves(json.loads(row)))
        like = max(fields, key=lambda other: len(was.items() & other.items()), default=None) if number < SHOWN else None
        if like is None:
            yield f"is missing: {row}"
            continue
        fields.remove(like)
        keys = [key for key in dict.fromkeys([*was, *like]) if was.get(key) != like.get(key)]
        same = ", ".join(f"{value}" for key, value in was.items() if key not in keys)[:120]
        yield f"{same}: " + "; ".join(f"{key} was {was.get(key)!r}, is {like.get(key)!r}" for key in keys)
    for row in gained[len(lost) :]:
        yield f"is new: {row}"


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """The values of a record by their dotted names."""
    if isinstance(value, (dict, list)):
        for key, one in value.items() if isinstance(value, dict) else enumerate(value):
            yield from leaves(one, f"{path}.{key}" if path else str(key))
    else:
        yield path, value


def read(path: Path) -> Any:
    """The JSON of a compressed file."""
    with gzip.open(path, "rt", encoding="utf-8") as file:
        return json.load(file)


def write(path: Path, value: Any) -> None:
    """Write a compressed file of JSON, the same bytes for the same value."""
    text = json.dumps(value, sort_keys=True, separators=(",", ":"), ensure_ascii=False)
    path.write_bytes(gzip.compress(text.encode(), mtime=0))


if __name__ == "__main__":
    sys.exit(main())
