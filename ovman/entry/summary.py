"""What an evaluation comes to: rates by relation with intervals and SPL, and what stands beside them. As JSON and as text."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass

from ovman.analysis.outcomes import Case, embodied_outcomes
from ovman.analysis.rates import Rate, embodied_rates
from ovman.entry import tables
from ovman.entry.beside import Beside, set_beside
from ovman.entry.manifest import Manifest
from ovman.entry.release import Release
from ovman.entry.score_page import as_values
from ovman.records.episode import Episode
from ovman.records.run import Score
from ovman.settings import Kind

SCHEMA = "ovman-embodied-score/1"


@dataclass(frozen=True, slots=True)
class Summary:
    """Rates of the runs of one arm by relation, then all, means over its seeds.

    beside: has released arms and tests where all episodes of a released split were run.
    """

    manifest: Manifest
    rates: Sequence[Rate]
    beside: Beside


def summary_of(runs: Sequence[Score], episodes: Sequence[Episode], manifest: Manifest, release: Release) -> Summary:
    """The summary of runs, each seed's over all of these episodes. settings of the release: as for `score_file`."""
    outcomes = embodied_outcomes([Case.of(episode) for episode in episodes], runs)
    rates = embodied_rates(outcomes, release.settings.evaluation.confidence)
    return Summary(manifest, rates, set_beside(outcomes, Kind.EMBODIED, manifest.split, release, manifest.whole))


def as_json(summary: Summary) -> str:
    """One JSON object with a line feed."""
    manifest = summary.manifest
    made = {
        "schema": SCHEMA,
        "arm": manifest.arm,
        "agent": manifest.agent,
        "split": manifest.split,
        "whole": manifest.whole,
        "handed": manifest.handed,
        "n": manifest.n,
        "asked": len(manifest.asked),
        "seeds": manifest.seeds,
        **({"repeated": [one.to_json() for one in manifest.repeated]} if manifest.repeated else {}),
        "rates": [asdict(rate) for rate in summary.rates],
        **as_values(summary.beside),
    }
    return json.dumps(made, indent=1) + "\n"


def as_text(summary: Summary, markdown: bool) -> str:
    """Lines for a terminal, or a page of Markdown."""
    return "\n".join(_lines(summary, markdown)) + "\n"


def _lines(summary: Summary, markdown: bool) -> Iterator[str]:
    manifest = summary.manifest
    of = "episodes of a file" if manifest.split is None else f"the split {manifest.split}"
    seeds = f"{len(manifest.seeds)} seeds" if len(manifest.seeds) > 1 else f"seed {manifest.seeds[0]}"
    part = f"{manifest.n} episodes" if manifest.whole else f"PARTIAL, {len(manifest.asked)} of {manifest.n} episodes, no score"
    yield f"{'# ' if markdown else ''}{manifest.arm} ({manifest.agent}) on {of}, {seeds}: {part}"
    if manifest.handed:
        yield from ("", f"DIAGNOSTIC: the agent is handed the truth ({', '.join(manifest.handed)}); this is no system's score")
    if manifest.repeated:
        runs = f"{len(manifest.repeated)} of {len(manifest.asked) * len(manifest.seeds)} runs"
        first = f"{manifest.repeated[0].episode}, seed {manifest.repeated[0].seed}"
        yield from ("", f"TAKEN AGAIN: {runs} took several attempts, such as {first}; the leaderboard counts them as failures")
    yield from ("", *tables.table(tables.of_arm(summary.rates, summary.beside.chance), markdown))
    if summary.beside.released:
        yield from ("", "Beside it: success of the released arms on the same episodes, and p of McNemar's exact test by seed", "")
        yield from tables.table(tables.beside(summary.rates, summary.beside, "this evaluation"), markdown)
        for line in tables.said(summary.rates, summary.beside):
            yield from ("", line)
    if summary.beside.entries:
        yield from ("", tables.ENTRIES, "", *tables.table(tables.entries(summary.beside), markdown))
