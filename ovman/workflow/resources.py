"""Time and memory of each rule for a cluster, derived from benchmarks: `python -m ovman.workflow.resources [DIRECTORY ...]`.

DIRECTORY is a working directory in which the workflow has run. What its jobs took is kept in profiles/slurm/measured.csv, one
line a rule; of several directories the one with most episodes counts. From these lines the `set-resources` of the profile are
written, without a DIRECTORY from those that are there. A rule without a line is refused, so that no new one is forgotten.
"""

from __future__ import annotations

import csv
import math
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from ovman.atomic import replace_bytes

ROOT = Path(__file__).resolve().parents[2]
PROFILE = ROOT / "profiles" / "slurm" / "config.yaml"
MEASURED = PROFILE.with_name("measured.csv")
MARK = "# What follows is written by `python -m ovman.workflow.resources` from measured.csv.\n"
SCENES, EPISODES = 20, 608
"""Of the main job: the numbers are for it, and a smaller run's are scaled to it."""
TIMES_LONGER, LEAST_MIN, STEP_MIN = 3.0, 5, 5
"""Headroom: a processor that is half as fast, on a file system that others use, from which Python starts, too."""
TIMES_LARGER, LEAST_MB, STEP_MB = 1.5, 1_000, 500
"""Headroom: a benchmark looks now and then, misses peaks, and sees nothing at all of what lasts less than a second."""
OWN_MB, MOST_MB = 120.0, 2_100.0
"""Of a job's memory what does not grow with its records, Python and its imports; and what no job of a whole run exceeds."""

LIKE: Mapping[str, str] = {
    "simulator": "scenes",
    "static_tables": "metrics",
    "controls": "metrics",
    "paper_controls": "metrics",
    "all_tables": "tables",
    "crops": "cues",
    "cues_of_scene": "cues",
    "labels_of_scene": "labels",
    "maps_of_scene": "maps",
    "maintained_of_scene": "maintained",
    "ablation_episodes": "episodes",
    "ablated_tours": "trials",
    "ablated_maps": "detections",
    "ablated_predictions": "predictions",
    "ablation": "metrics",
    "split_tables": "tables",
    "figures": "tables",
    "charts": "tables",
    "paper_comparison": "tables",
    "pictures": "trials",
    "models": "tables",
}
"""Rules that no run of the main job measures, and the rule that does the like of it."""
TRAINING: Mapping[str, tuple[int, int]] = {
    "detected": (120, 4_000),
    "detector_first": (1_440, 8_000),
    "detector": (1_440, 8_000),
    "encoder_true": (1_440, 8_000),
    "encoder": (1_440, 8_000),
}
"""Minutes and MB of the rules that train and export networks. No run of the main job measures them; their cards say hours."""

RULE = re.compile(r"^(?:use rule|rule|checkpoint) (\w+)(?: as (\w+) with)?:\n(.*?)(?=^\S|\Z)", re.MULTILINE | re.DOTALL)
BENCHMARK = re.compile(r'^    benchmark:\n        "benchmarks/(.+)\.tsv"', re.MULTILINE)
WILDCARDS = {"scene": r"FloorPlan\d+(?:-FloorPlan\d+)?", "of": r"(?:[a-z0-9_]+/)?"}


@dataclass(frozen=True)
class Measured:
    """What the jobs of a rule took at most: seconds of the clock and MB resident, in a run of so many scenes and episodes.

    of_scene: whether a job is of one scene, or of a batch of a few, else of all of them.
    """

    rule: str
    jobs: int
    of_scene: bool
    seconds: float
    megabytes: float
    scenes: int
    episodes: int


class ResourcesError(ValueError):
    """A rule's resources cannot be derived; one line with the remedy."""


def rules(root: Path = ROOT) -> dict[str, str | None]:
    """Every rule of the workflow, and where its benchmarks lie below benchmarks/, with wildcards; None where it has none."""
    found: dict[str, str | None] = {}
    for path in (root / "Snakefile", *sorted((root / "workflow" / "rules").glob("*.smk"))):
        for base, name, body in RULE.findall(path.read_text(encoding="utf-8")):
            benchmark = BENCHMARK.search(body)
            found[name or base] = benchmark[1] if benchmark else None
    return found


def local(root: Path = ROOT) -> set[str]:
    """The rules that Snakemake's own process runs."""
    block = re.search(r"^localrules:\n((?:    \w+,\n)+)", (root / "Snakefile").read_text(encoding="utf-8"), re.MULTILINE)
    return set(re.findall(r"\w+", block[1])) if block else set()


def measured(directory: Path, names: Mapping[str, str | None]) -> list[Measured]:
    """What a working directory's benchmarks say of each rule. ResourcesError where there are none."""
    folder = directory / "benchmarks"
    files = [path.relative_to(folder).with_suffix("").as_posix() for path in sorted(folder.rglob("*.tsv"))]
    if not files:
        raise ResourcesError(f"{folder}: has no benchmarks; name a directory in which the workflow has run")
    scenes = len([*(directory / "results" / "scenes").glob("*.json")])
    episodes = sum(
        path.read_bytes().count(b"\n")
        for path in (directory / "results" / "episodes").glob("*.jsonl")
        if not path.stem.endswith("sightings")
    )
    found = []
    for rule, template in names.items():
        pattern = re.compile(_pattern(template)) if template else None
        rows = [_row(folder / f"{name}.tsv") for name in files if pattern and pattern.fullmatch(name)]
        if rows and template:
            seconds, megabytes = (max(column) for column in zip(*rows, strict=True))
            of_scene = "{scene}" in template
            found.append(Measured(rule, len(rows), of_scene, round(seconds, 1), round(megabytes), scenes, episodes))
    return found


def _pattern(template: str) -> str:
    """A template of Snakemake as a regular expression."""
    parts = re.split(r"\{(\w+)\}", template)
    return "".join(re.escape(part) if k % 2 == 0 else WILDCARDS.get(part, r"[a-z0-9_]+") for k, part in enumerate(parts))


def _row(path: Path) -> tuple[float, float]:
    """Seconds and MB of a benchmark; what was not seen is 0."""
    with path.open(newline="") as file:
        (row,) = csv.DictReader(file, delimiter="\t")
    return float(row["s"]), float(row["max_rss"]) if row["max_rss"] not in ("NA", "-", "") else 0.0


def read(path: Path = MEASURED) -> list[Measured]:
    """The lines that are kept."""
    with path.open(newline="", encoding="utf-8") as file:
        return [
            Measured(
                row["rule"],
                int(row["jobs"]),
                row["of_scene"] == "True",
                float(row["seconds"]),
                float(row["megabytes"]),
                int(row["scenes"]),
                int(row["episodes"]),
            )
            for row in csv.DictReader(file)
        ]


def write(lines: Iterable[Measured], path: Path = MEASURED) -> None:
    """Keep lines, by rule."""
    rows = [[field.name for field in fields(Measured)], *(astuple(one) for one in sorted(lines, key=lambda one: one.rule))]
    replace_bytes(path, "".join(",".join(map(str, row)) + "\n" for row in rows).encode())


def asked(one: Measured) -> tuple[int, int]:
    """Minutes and MB to ask for at the size of the main job.

    Time grows with a job's episodes. Memory of a job of a scene does not, since its records are few and pictures go one by one;
    that of a job of all scenes may, but for `OWN_MB`, up to `MOST_MB`.
    """
    growth = EPISODES / one.episodes * (one.scenes / SCENES if one.of_scene else 1.0)
    seconds = one.seconds * max(growth, 1.0) * TIMES_LONGER
    grown = OWN_MB + max(one.megabytes - OWN_MB, 0.0) * max(growth, 1.0)
    megabytes = one.megabytes if one.of_scene else max(one.megabytes, min(grown, MOST_MB))
    return _up(seconds / 60.0, STEP_MIN, LEAST_MIN), _up(megabytes * TIMES_LARGER, STEP_MB, LEAST_MB)


def _up(value: float, step: int, least: int) -> int:
    return max(least, math.ceil(value / step) * step)


def resources(lines: Iterable[Measured], names: Iterable[str]) -> dict[str, tuple[int, int]]:
    """Minutes and MB of each rule. ResourcesError for one that has neither measurements nor a like."""
    known = {one.rule: asked(one) for one in lines}
    found = {}
    for name in sorted(names):
        if name in TRAINING:
            found[name] = TRAINING[name]
        elif (of := LIKE.get(name, name)) in known:
            found[name] = known[of]
        else:
            raise ResourcesError(
                f"the rule {name} has no resources for a cluster; run it, then: python -m ovman.workflow.resources DIRECTORY"
            )
    return found


def profile(head: str, lines: Iterable[Measured], names: Iterable[str]) -> str:
    """The profile's text: what is before the mark stays, what follows is derived. A job that is tried again gets more."""
    of = resources(lines, names)
    text = head.partition(MARK)[0] + MARK
    text += f"default-resources:\n  runtime: {max(minutes for minutes, _ in known(of))} * attempt\n"
    text += f"  mem_mb: {max(megabytes for _, megabytes in known(of))} * attempt\n"
    text += "set-resources:\n"
    for name, (minutes, megabytes) in of.items():
        text += f"  {name}: {{runtime: {minutes} * attempt, mem_mb: {megabytes} * attempt}}\n"
    return text


def known(of: Mapping[str, tuple[int, int]]) -> list[tuple[int, int]]:
    """What all rules ask for but those that train networks."""
    return [pair for name, pair in of.items() if name not in TRAINING]


def main(arguments: Sequence[str]) -> int:
    """Returns the exit status. arguments: working directories."""
    names = rules()
    lines = {one.rule: one for one in read()} if MEASURED.exists() else {}
    try:
        for directory in arguments:
            for one in measured(Path(directory), names):
                if one.rule not in lines or one.episodes >= lines[one.rule].episodes:
                    lines[one.rule] = one
        lines = {rule: one for rule, one in lines.items() if rule in names}
        text = profile(PROFILE.read_text(encoding="utf-8"), lines.values(), names.keys() - local())
    except ResourcesError as error:
        print(error, file=sys.stderr)
        return 2
    write(lines.values())
    replace_bytes(PROFILE, text.encode())
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
