"""The commands `ovman record` and `ovman replay`."""

from __future__ import annotations

from pathlib import Path

from ovman.doctor import rehearsal
from ovman.settings.benchmark import floor_plan
from ovman.settings.config import load
from ovman.sim.recording.file import read
from ovman.workflow.parameter import stage_settings

EMBEDDED, THOR = "embedded", "thor"


def record(scene: str, output: Path, thor: bool, config: Path) -> str:
    """Record the work on a scene and return a summary in one line. ValueError, in one line, if that is impossible."""
    floor_plan(scene)
    settings = load(config)
    benchmark = settings.benchmark.model_copy(update={"backend": THOR if thor else EMBEDDED})
    chosen = settings.model_copy(update={"benchmark": benchmark})
    recording = rehearsal.record(scene, {stage: stage_settings(chosen, stage) for stage in rehearsal.STAGES}, output)
    calls = sum(1 for _ in recording.calls())
    return f"{output}: {calls} calls of {recording.header.backend} on {scene}, {output.stat().st_size / 1e6:.1f} MB"


def replay(path: Path, thor: bool) -> tuple[bool, list[str]]:
    """Replay a recording both ways: whether all differences are allowed ones, and a summary in lines.

    ValueError, in one line, if the file is no recording or OVMAN's code now calls the simulator differently.
    """
    recording = read(path)
    of, now = recording.header.backend, THOR if thor else EMBEDDED
    versions = ", ".join(f"{name} {number}" for name, number in recording.header.versions.items())
    said = [f"recorded: {of} on {recording.header.scene}, {versions}, {', '.join(recording.header.platform.values())}"]
    changed = rehearsal.rehearsed(recording)
    said.append(
        f"the same work on the recorded answers: {len(recording.results())} results, otherwise: {', '.join(changed) or 'none'}"
    )
    summaries = rehearsal.compared(recording, now)
    told = [s for s in summaries if s.rule is None]
    said.append(
        f"the same calls asked of {now}: {len(summaries) - len(told)} keys differ as they may, {len(told)} as they may not"
    )
    said += [f"NO  {summary}" for summary in told]
    said += [f"--  {summary} ({summary.rule.why})" for summary in summaries if summary.rule is not None]
    return not changed and not told, said
