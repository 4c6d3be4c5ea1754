"""Measure the overhead of the workflow, the cost of a changed threshold, and growth with scenes.

    python bench/workflow.py [--growth [TARGET]]

Runs the jobs of `make quick` in a temporary directory, then all of them again with a full cache, so that no simulator starts. The
second run is the overhead, pure stages included. CPU time is that of all processes.

--growth measures scenes of the tiny world one by one, then together. If cost grows in proportion, together they cost what they
cost one by one, or less, because Snakemake starts once.
"""

from __future__ import annotations

import argparse
import csv
import os
import platform
import re
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
QUICK = ROOT / "overlays" / "quick.yaml"
TINY = ROOT / "overlays" / "tiny.yaml"
GROWING = ("FloorPlan227", "FloorPlan7", "FloorPlan330")


def snakemake(directory: str, files: list[Path], *arguments: str, target: str = "results/tables") -> tuple[float, float, str]:
    """Run Snakemake; return seconds of wall clock and of CPU, and its output."""
    configuration = ["--configfile", *map(str, files)] if files else []
    command = [
        sys.executable,
        "-m",
        "snakemake",
        "--snakefile",
        str(ROOT / "Snakefile"),
        "--directory",
        directory,
        "--cores",
        "2",
    ]
    before, start = resource.getrusage(resource.RUSAGE_CHILDREN), time.perf_counter()
    done = subprocess.run(
        [*command, *configuration, *arguments, "--", target], cwd=ROOT, capture_output=True, text=True, check=False
    )
    wall, after = time.perf_counter() - start, resource.getrusage(resource.RUSAGE_CHILDREN)
    if done.returncode != 0:
        sys.exit(done.stderr)
    return wall, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, done.stdout + done.stderr


def jobs(said: str) -> int:
    """Return the number of jobs in Snakemake's output."""
    total = re.search(r"^total +(\d+)", said, re.MULTILINE)
    if total is None:
        raise ValueError("Snakemake printed no total of jobs")
    return int(total[1])


def resident_mb(directory: str) -> float:
    """Return the memory of the largest job, child processes included."""
    rows = [row for path in Path(directory, "benchmarks").rglob("*.tsv") for row in csv.DictReader(path.open(), delimiter="\t")]
    return max(float(row["max_rss"]) for row in rows if row["max_rss"] not in ("NA", "-"))


def row(name: str, wall: float, cpu: float, note: str = "") -> None:
    """Print one line of the report."""
    print(f"{name:<46}{wall:8.1f} s wall{cpu:8.1f} s CPU  {note}")


def growth(target: str) -> None:
    """Print the cost of a target for each scene alone, and for all together."""
    alone: list[float] = []
    for scenes in (*([scene] for scene in GROWING), GROWING):
        with tempfile.TemporaryDirectory() as directory:
            change = Path(directory, "scenes.yaml")
            change.write_text(f"benchmark: {{allow_short_split: true}}\nsplits: {{main: {{scenes: [{', '.join(scenes)}]}}}}\n")
            wall, cpu, _ = snakemake(directory, [TINY, change], target=target)
        together = len(scenes) > 1
        note = f"{cpu / sum(alone):.2f} of what they cost one by one" if together else ""
        row(f"{target}, {len(scenes)} scenes" if together else f"{target}, {scenes[0]}", wall, cpu, note)
        alone.append(cpu)


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description=str(__doc__).splitlines()[0])
    parser.add_argument(
        "--growth", metavar="TARGET", nargs="?", const="results/tables", help="measure how this target grows with scenes"
    )
    asked = parser.parse_args()
    print(f"{platform.processor() or platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}")
    if asked.growth is not None:
        growth(asked.growth)
        return
    with tempfile.TemporaryDirectory() as directory:
        wall, cpu, said = snakemake(directory, [QUICK])
        count = jobs(said)
        row("make quick, without set-up", wall, cpu, f"{count} jobs, at most {resident_mb(directory):.0f} MB resident")
        again_wall, again_cpu, _ = snakemake(directory, [QUICK], "--forceall")
        row("all of it again, no simulator", again_wall, again_cpu, f"{again_cpu / cpu:.1%} of its CPU time")
        change = Path(directory, "change.yaml")
        change.write_text("admissibility: {drift_tolerance_m: 0.26}\n")
        row("another drift tolerance, to new tables", *snakemake(directory, [QUICK, change])[:2])


if __name__ == "__main__":
    main()
