"""The summary of an evaluation: rates by relation with intervals and SPL, and baselines. As JSON and as text."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from ovman.analysis.outcomes import embodied_outcomes
from ovman.analysis.rates import Rate, arm_rates
from ovman.atomic import replace_bytes
from ovman.entry import tables
from ovman.entry.manifest import RUNS, Manifest
from ovman.entry.release import Baselines, Release, compare_with_baselines
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.run import Score
from ovman.settings import Kind
from ovman.settings.arms import Track

SCHEMA = "ovman-embodied-score/1"
SUMMARY, PAGE = "summary.json", "summary.md"


@dataclass(frozen=True, slots=True)
class Summary:
    """Rates of the runs of one arm by relation, then all, means over its seeds.

    baselines: With released arms and tests if all episodes of a released split were run.
    """

    manifest: Manifest
    rates: Sequence[Rate]
    baselines: Baselines


def write_results(out: Path, runs: Sequence[Score], episodes: Sequence[Episode], manifest: Manifest, release: Release) -> Summary:
    """Write runs and summary. runs: Seed by seed, each over these episodes in their order."""
    summary = summarise(runs, episodes, manifest, release)
    replace_bytes(out / RUNS, lines(runs).encode())
    replace_bytes(out / SUMMARY, as_json(summary).encode())
    replace_bytes(out / PAGE, as_text(summary, markdown=True).encode())
    return summary


def summarise(runs: Sequence[Score], episodes: Sequence[Episode], manifest: Manifest, release: Release) -> Summary:
    """Return the summary of runs, each seed's over all of these episodes."""
    outcomes = embodied_outcomes(episodes, runs)
    rates = arm_rates(outcomes, release.settings.evaluation.confidence)
    baselines = compare_with_baselines(outcomes, Kind.EMBODIED, manifest.split, release, manifest.is_whole)
    return Summary(manifest, rates, baselines)


def as_json(summary: Summary) -> str:
    """Return one JSON object with a line feed."""
    manifest = summary.manifest
    value = {
        "schema": SCHEMA,
        "arm": manifest.arm,
        "agent": manifest.agent,
        "split": manifest.split,
        **({} if manifest.track is Track.PAPER else {"track": str(manifest.track)}),
        **({} if manifest.draw is None else {"draw": manifest.draw}),
        "whole": manifest.is_whole,
        **({"isolation": str(manifest.isolation)} if manifest.isolation else {}),
        "handed": manifest.handed,
        "n": manifest.n,
        "asked": len(manifest.asked),
        "seeds": manifest.seeds,
        **({"repeated": [one.to_json() for one in manifest.repeated]} if manifest.repeated else {}),
        "rates": [asdict(rate) for rate in summary.rates],
        **tables.baseline_values(summary.baselines),
    }
    return json.dumps(value, indent=1) + "\n"


def as_text(summary: Summary, markdown: bool) -> str:
    """Return lines for a terminal, or a page of Markdown."""
    return "\n".join(_lines(summary, markdown)) + "\n"


def _lines(summary: Summary, markdown: bool) -> Iterator[str]:
    manifest, rates, baselines = summary.manifest, summary.rates, summary.baselines
    drawn = "episodes of a file" if manifest.draw is None else f"the draw {manifest.draw}"
    of = drawn if manifest.split is None else f"the split {manifest.split}"
    seeds = f"{len(manifest.seeds)} seeds" if len(manifest.seeds) > 1 else f"seed {manifest.seeds[0]}"
    partial = f"PARTIAL, {len(manifest.asked)} of {manifest.n} episodes, no score"
    part = f"{manifest.n} episodes" if manifest.is_whole else partial
    yield f"{'# ' if markdown else ''}{manifest.arm} ({manifest.agent}) on {of}, {seeds}: {part}"
    yield from ("", f"The agent ran: {manifest.ran}.")
    if manifest.handed:
        yield from ("", f"DIAGNOSTIC: the agent is handed the truth ({', '.join(manifest.handed)}); this is no system's score")
    if manifest.repeated:
        runs = f"{len(manifest.repeated)} of {len(manifest.asked) * len(manifest.seeds)} runs"
        first = f"{manifest.repeated[0].episode}, seed {manifest.repeated[0].seed}"
        yield from ("", f"TAKEN AGAIN: {runs} took several attempts, such as {first}; the leaderboard counts them as failures")
    yield from ("", *tables.table(tables.rate_rows(rates, baselines.chance), markdown))
    yield from tables.baseline_lines(rates, baselines, "this evaluation", markdown)
