"""The release: what results/ holds that others need, as one directory with a dataset card and checksums."""

from __future__ import annotations

import hashlib
import math
import shutil
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis.rows import read_rows
from ovman.atomic import check_own
from ovman.records.episode import Episode
from ovman.records.task import Rejection, Relation
from ovman.report import archive, layout
from ovman.report.tables.table import pipe_table
from ovman.shipped import HOME
from ovman.workflow import checksums, made
from ovman_engine.plan import floorplan


@dataclass(frozen=True, slots=True)
class RejectionCount:
    """How many candidates of a relation a stage rejected for a reason, or one of the totals."""

    relation: str
    stage: str
    reason: str
    count: int


FILES = ("episodes/main.jsonl", "episodes/sightings.jsonl")
"""What no release lacks."""
SUMS = "SHA256SUMS"
HIDDEN = "."
NEAR_M = 1.0
"""From a vacated place to another instance of the category that the card counts as beside it."""


def release(results: Path, output: Path, card: str, perceived: Path | None = None, home: Path = HOME) -> list[Path]:
    """Copy the results that are released into `output`, beside `card` and SHA256SUMS; returns the files, relative, sorted.

    With them goes what `ovman restore` needs: what made every output, and an archive of what is left of a run. perceived: where
    the large archive goes, which is no part of `output`. `output` is made anew; home: the checkout that made the results.
    FileNotFoundError names the file of `results` that is not there, ValueError one that is not what its rule wrote.
    """
    making = made.making(results.parent, home)
    digests = making.files()
    check_own(output, SUMS)
    shutil.rmtree(output, ignore_errors=True)
    sources = {Path(name): results / name for name in FILES}
    for tree, released in layout.TREES.items():
        files = sorted(p for p in (results / tree).rglob("*") if p.is_file() and p.name[0] != HIDDEN)
        sources |= {Path(released, p.relative_to(results / tree)): p for p in files}
    for name, source in sources.items():
        if not source.is_file():
            raise FileNotFoundError(f"{source} is not there; make it first: make tables")
        (output / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(source, output / name)
        _check(checksums.MADE / source.relative_to(results), checksums.digest_of(output / name), digests)
    names = [*sources, *made.write(making, output), layout.MEASUREMENTS]
    journals = (path for tree in layout.JOURNALS for path in (results / tree).rglob("*.jsonl"))
    kept = [(checksums.MADE / path.relative_to(results)).as_posix() for path in journals]
    there = [name for name in digests if (results.parent / name).is_file()]
    _pack(results.parent, [*filter(layout.measured, there), *kept], digests, output / layout.MEASUREMENTS)
    if perceived is not None:
        _pack(results.parent, [name for name in there if layout.within(name, layout.PERCEIVED)], digests, perceived)
    (output / "README.md").write_text(card, encoding="utf-8")
    names.append(Path("README.md"))
    sums = [f"{hashlib.sha256((output / n).read_bytes()).hexdigest()}  {n.as_posix()}\n" for n in sorted(names)]
    (output / SUMS).write_text("".join(sums), encoding="utf-8")
    return sorted(names)


def _pack(directory: Path, names: Sequence[str], digests: Mapping[str, str], place: Path) -> None:
    """Write an archive of files of results/, each of which is what its rule wrote."""
    for name in names:
        _check(Path(name), checksums.digest_of(directory / name), digests)
    archive.pack(directory, names, place)


def _check(name: Path, found: str, digests: Mapping[str, str]) -> None:
    """ValueError for a file whose SHA-256 is not what its rule wrote. Journals, and what no rule wrote, have none."""
    if digests.get(name.as_posix(), found) != found:
        raise ValueError(f"{name}: has changed since its rule wrote it; make it again: snakemake --cores 2 --force -- {name}")


def _table(header: Sequence[str], body: Sequence[Sequence[str]], words: int = 1) -> str:
    """A table whose first `words` columns are text and the others numbers."""
    return pipe_table(header, body, [index >= words for index in range(len(header))]).rstrip()


def _counts(episodes: Sequence[Episode], key: Callable[[Episode], str]) -> list[list[str]]:
    """A row for each value of `key`, sorted by number of episodes: value, six relations, all."""
    table: dict[str, Counter[str]] = {}
    for episode in episodes:
        table.setdefault(key(episode), Counter())[episode.relation.value] += 1
    rows = sorted(table.items(), key=lambda item: (-item[1].total(), item[0]))
    return [[name, *(str(counts[r.value] or "") for r in Relation), str(counts.total())] for name, counts in rows]


def _rejections(rows: Sequence[RejectionCount]) -> list[list[str]]:
    """A row for each stage and reason, in the order of Algorithm 1: what was drawn, what was rejected, what is left."""
    order = [("drawn", ""), *((r.stage.value, r.value) for r in Rejection), ("certified", ""), ("released", "")]
    count = Counter({(row.stage, row.reason, row.relation): row.count for row in rows})
    table = []
    for stage, reason in order:
        counts = [count[stage, reason, relation.value] for relation in Relation]
        if sum(counts):
            table.append([stage, reason.replace("_", " "), *(str(n or "") for n in counts), str(sum(counts))])
    return table


def card(results: Path) -> str:
    """The dataset card of the episodes in `results`, Markdown."""
    episodes = Episode.load(results / "episodes" / "main.jsonl")
    rejected = read_rows(results / "metrics" / "main" / "rejections.csv", RejectionCount)
    trials = sum(1 for path in (results / "trials").glob("*.jsonl") for line in path.read_text().splitlines() if line)
    kind = {name: floorplan.load(name).kind.replace("_", " ") for name in {e.scene for e in episodes}}
    relations = [r.value for r in Relation]
    instances = Counter(min(e.instances_in_category, 4) for e in episodes)
    shortest = sorted(e.shortest_path_m for e in episodes)
    vacated = [e for e in episodes if e.relation.past]
    return (
        (Path(__file__).parent / "card.md")
        .read_text(encoding="utf-8")
        .format(
            episodes=len(episodes),
            scenes=len(kind),
            trials=trials,
            kinds=", ".join(f"{n} {k}{'s' if n > 1 else ''}" for k, n in Counter(kind.values()).most_common()),
            by_relation=_table([*relations, "all"], [_counts(episodes, lambda e: "")[0][1:]], 0),
            further=_table(["split", *relations, "all"], _counts(_further(results), lambda e: e.split)),
            by_scene=_table(["scene", *relations, "all"], _counts(episodes, lambda e: f"{e.scene} ({kind[e.scene]})")),
            by_category=_table(["category", *relations, "all"], _counts(episodes, lambda e: e.category)),
            rejections=_table(["stage", "reason", *relations, "all"], _rejections(rejected), 2),
            instances=", ".join(f"{count} with {'four or more' if n == 4 else n}" for n, count in sorted(instances.items())),
            vacated=len(vacated),
            beside=sum(_beside(e) for e in vacated),
            near=f"{NEAR_M:g}",
            shortest=f"{shortest[0]:.2f}, {shortest[len(shortest) // 2]:.2f} and {shortest[-1]:.2f}",
        )
    )


def _further(results: Path) -> list[Episode]:
    """The episodes of the splits beside the main one, each of which has a file of sightings of its own."""
    names = sorted(path.name.replace("_sightings", "") for path in (results / "episodes").glob("*_sightings.jsonl"))
    return [episode for name in names for episode in Episode.load(results / "episodes" / name)]


def _beside(episode: Episode) -> bool:
    """Whether an instance of the category is near the answer in the second visit."""
    return any(math.dist(k.position, episode.answer) <= NEAR_M for k in episode.states[1].category(episode.category))


def run(results: Path, output: Path, perceived: Path | None = None) -> None:
    """Release `results` into `output`, and into the large archive `perceived`. SystemExit with what is wrong, in one line."""
    try:
        names = release(results, output, card(results), perceived)
    except (ValueError, FileNotFoundError) as error:
        raise SystemExit(str(error)) from None
    size = sum((output / name).stat().st_size for name in names)
    print(f"{output}: {len(names)} files, {size / 1e6:.1f} MB")
    if perceived is not None:
        print(f"{perceived}: {perceived.stat().st_size / 1e6:.1f} MB; publish it beside the release")


if __name__ == "__main__":
    run(*(Path(argument) for argument in sys.argv[1:]))
