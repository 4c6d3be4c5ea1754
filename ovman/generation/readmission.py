"""Stage `readmitted`: the verdict on every trial under other thresholds, and episodes of all that any admits. Pure.

Nothing is certified anew: admissibility is re-derived from what was measured, and the oracle has run only what the setting in
force admits. A trial's episode has no certification runs, and its answer does not depend on a threshold.
"""

from __future__ import annotations

from collections.abc import Sequence
from operator import attrgetter
from pathlib import Path

from ovman.generation.release import episode
from ovman.generation.verdict import against_drift, against_geometry, against_observations
from ovman.records.episode import Episode
from ovman.records.record import lines
from ovman.records.task import Rejection
from ovman.records.trial import Admission, Trial
from ovman.settings import Settings
from ovman.settings.comparisons import THRESHOLDS

OBSERVED = attrgetter(*(THRESHOLDS[name] for name in ("tau_m", "delta_min_m", "min_mask_px", "motion_m")))
"""The thresholds that `against_observations` reads: tours are judged once for each combination of these."""


def settings_of(constants: Settings) -> tuple[Settings, ...]:
    """Return the setting in force, then every setting of section `sensitivity`."""
    others = constants.sensitivity.settings()
    return constants, *(constants.with_values({THRESHOLDS[name]: value for name, value in one.items()}) for one in others)


def admitting(trial: Trial, settings: Sequence[Settings]) -> tuple[int, ...]:
    """Return the numbers of the settings under which a trial is admissible."""
    candidate, measured = trial.candidate, trial.measured
    if isinstance(measured.ended, Rejection):
        return ()
    seen: dict[tuple[float, ...], bool] = {}

    def observed(constants: Settings) -> bool:
        key = OBSERVED(constants)
        if key not in seen:
            seen[key] = not any(against_observations(candidate, measured, constants))
        return seen[key]

    return tuple(
        number
        for number, constants in enumerate(settings)
        if not any(against_geometry(candidate, measured, constants))
        and measured.sightings is not None
        and not any(against_drift(measured, constants))
        and observed(constants)
    )


def run(trials_file: Path, episodes_file: Path, constants: Settings, episodes_out: Path, admissions_out: Path) -> None:
    """Write an episode of each trial of main that some setting admits, and the admitting settings, in the order of trials.

    episodes_file: the released ones.
    """
    released = {one.id for one in Episode.load(episodes_file)}
    settings = settings_of(constants)
    episodes: list[Episode] = []
    admissions: list[Admission] = []
    for trial in Trial.read(trials_file):
        name = trial.candidate.id
        if numbers := admitting(trial, settings):
            episodes.append(episode(trial, (), constants))
            admissions.append(Admission(id=name, settings=numbers, released=name in released))
    episodes_out.write_text(lines(episodes), encoding="utf-8")
    admissions_out.write_text(lines(admissions), encoding="utf-8")
    counts = f"{sum(0 in one.settings for one in admissions)} are admissible, {len(released)} released"
    print(f"{len(settings)} settings admit {len(admissions)} trials; {counts}", flush=True)
