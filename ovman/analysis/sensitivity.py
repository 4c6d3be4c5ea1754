"""The stage "sensitivity": how far the margin of memory depends on the thresholds of admissibility.

Admissibility is re-derived under every setting of section `sensitivity` (`ovman.generation.readmission`). The margin is the
success of comparisons.memory's arm less that of its baseline, over the trials that a setting admits. Predictions are the same
under all settings, as the agent's own constants stay. No setting but the one in force was certified, so certification counts
under none; `released_margin` is the other reading: over those of the released episodes, all certified, that a setting leaves.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.analysis import frames
from ovman.analysis.outcomes import Case, judged
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.trial import Admission
from ovman.settings import Settings
from ovman.settings.sensitivity import THRESHOLDS


@dataclass(frozen=True, slots=True)
class Margin:
    """The margin of memory under one setting. setting: its number, 0 for the one in force; then its thresholds.

    episodes: how many trials it admits; rate, baseline_rate: success on them with and without the first visit; margin: their
    difference. released, released_margin: the same over the released episodes among them. Rates are None where there is none.
    """

    setting: int
    in_force: bool
    drift_tolerance_m: float
    tau_m: float
    delta_min_m: float
    min_mask_px: int
    motion_m: float
    validity_radius_m: float
    spawn_clearance_m: float
    visible_px: int
    episodes: int
    rate: float | None
    baseline_rate: float | None
    margin: float | None
    released: int
    released_margin: float | None


def margins(
    admissions: Sequence[Admission], rates: Sequence[float], baseline_rates: Sequence[float], constants: Settings
) -> list[Margin]:
    """A row for the setting in force, then one for every setting.

    rates, baseline_rates: success with and without the first visit on each of the admissions, probabilities where an arm is a
    stochastic pick. ValueError for a setting that there is none of.
    """
    thresholds = [_in_force(constants), *constants.sensitivity.settings()]
    admitted = np.zeros((len(thresholds), len(admissions)), bool)
    for column, one in enumerate(admissions):
        if one.settings and one.settings[-1] >= len(thresholds):
            raise ValueError(f"{one.id}: there is no setting {one.settings[-1]}; make the stage readmitted again")
        admitted[list(one.settings), column] = True
    released = admitted & np.array([one.released for one in admissions], bool)
    success, baseline = np.array(rates, float), np.array(baseline_rates, float)
    rows = []
    for number, values in enumerate(thresholds):
        rate, baseline_rate = _mean(success, admitted[number]), _mean(baseline, admitted[number])
        rows.append(
            Margin(
                setting=number,
                in_force=number == 0,
                **values,  # type: ignore[arg-type]  # by the names of THRESHOLDS
                episodes=int(admitted[number].sum()),
                rate=rate,
                baseline_rate=baseline_rate,
                margin=_mean(success - baseline, admitted[number]),
                released=int(released[number].sum()),
                released_margin=_mean(success - baseline, released[number]),
            )
        )
    return rows


def run(
    admissions_file: Path, episodes_file: Path, arm_file: Path, baseline_file: Path, constants: Settings, output: Path
) -> None:
    """Write the margins. arm_file, baseline_file: predictions of the two arms for the episodes of the admissions.

    constants: sensitivity.*, what a verdict reads, comparisons.memory, success.radius_m, single_visit.samples, benchmark.seed.
    Raises ValueError in one line.
    """
    admissions = Admission.read(admissions_file)
    cases = [Case.of(episode) for episode in Episode.load(episodes_file)]

    def rates(file: Path) -> list[float]:
        success = {outcome.episode: outcome.success for outcome in judged(cases, Prediction.read(file), constants)}
        return [success[one.id] for one in admissions]

    rows = margins(admissions, rates(arm_file), rates(baseline_file), constants)
    frames.write(output, Margin, rows)
    found = [row.margin for row in rows[1:] if row.margin is not None]
    if found:
        print(f"{len(rows) - 1} settings: margin {min(found):.3f} to {max(found):.3f}, in force {rows[0].margin:.3f}", flush=True)


def _in_force(constants: Settings) -> dict[str, float]:
    places = {name: place.split(".") for name, place in THRESHOLDS.items()}
    return {name: getattr(getattr(constants, section), last) for name, (section, last) in places.items()}


def _mean(values: np.ndarray, chosen: np.ndarray) -> float | None:
    return float(values[chosen].mean()) if chosen.any() else None
