"""Agents asked again: under other association gates, relations and thresholds of admissibility.

Source: Fig. diag (b), and "the only confusions (REMOVED read as FORMER) resolve to the same answer location".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np

from ovman.analysis.outcomes import static_outcomes
from ovman.analysis.rows import Row, write_csv
from ovman.analysis.statistics import wilson_interval
from ovman.evaluation.observations import VISITS, store_opener
from ovman.evaluation.predictions import predict
from ovman.evaluation.scores import is_right
from ovman.generation.readmission import admitting, settings_of
from ovman.records.episode import Episode
from ovman.records.prediction import Answer, Predicted, Prediction
from ovman.records.task import Relation
from ovman.records.trial import Admission, Trial
from ovman.settings import Arm, Settings
from ovman.settings.comparisons import THRESHOLDS

GATES = "gate_m in_force delta_min_m n successes success low high confidence"
READ_AS = "relation read_as n answered same only_read_as successes successes_read_as"
MARGINS = f"setting in_force {' '.join(THRESHOLDS)} episodes rate baseline_rate margin released released_margin"
GATE = "association.gate_m"
SWAPPED: Mapping[Relation, Relation] = {Relation.REMOVED: Relation.FORMER, Relation.FORMER: Relation.REMOVED}
"""What each past relation is read as."""
Ask = Callable[[Episode, Settings], Predicted]
"""Returns the answer of an arm to an episode under some settings."""


def write_probes(arm: Arm, episodes_file: Path, maps: Path, nouns_file: Path, settings: Settings, directory: Path) -> None:
    """Write gate_sweep.csv and read_as.csv of an arm that needs maps at most. maps: directory of the maps of scenes.

    Settings: gate_sweep.*, association.gate_m, candidates.delta_min_m, success.radius_m, evaluation.confidence, and what the
    arm's entry names.
    """
    episodes = Episode.load(episodes_file)
    open_store = store_opener(arm, settings, VISITS, {"maps": maps, "nouns": nouns_file})

    def ask(episode: Episode, settings_of_gate: Settings) -> Predicted:
        return predict(arm, episode, settings_of_gate, open_store(episode.scene, episode.protocol.camera.field_of_view_deg))[0]

    write_csv(directory / "gate_sweep.csv", GATES, sweep_gates(episodes, ask, settings) if episodes else [])
    write_csv(directory / "read_as.csv", READ_AS, swap_relations(episodes, ask, settings))


def sweep_gates(episodes: Sequence[Episode], ask: Ask, settings: Settings) -> list[Row]:
    """Compute static success under each gate of section gate_sweep and the gate in force, ascending."""
    in_force, confidence, n = settings.association.gate_m, settings.evaluation.confidence, len(episodes)
    rows: list[Row] = []
    for gate_m in sorted({*settings.gate_sweep.gates_m, in_force}):
        with_gate = settings.with_values({GATE: gate_m})
        successes = sum(_succeeds(ask(one, with_gate), one, settings) for one in episodes)
        low, high = wilson_interval(successes, n, confidence)
        row = {"gate_m": gate_m, "in_force": gate_m == in_force, "delta_min_m": settings.candidates.delta_min_m, "n": n}
        row |= {"successes": successes, "success": successes / n, "low": low, "high": high, "confidence": confidence}
        rows.append(row)
    return rows


def swap_relations(episodes: Sequence[Episode], ask: Ask, settings: Settings) -> list[Row]:
    """Ask the episodes of each past relation as they are meant, and as if the other past relation had been said.

    same: of the `answered` ones, those with the same answer; only_read_as: those with an answer only as read, by the fallback.
    """
    rows: list[Row] = []
    for relation, other in SWAPPED.items():
        group = [one for one in episodes if one.relation is relation]
        meant = [ask(one, settings) for one in group]
        swapped = [ask(one.model_copy(update={"relation": other}), settings) for one in group]
        pairs = list(zip(meant, swapped, strict=True))
        row = {
            "relation": relation,
            "read_as": other,
            "n": len(group),
            "answered": sum(isinstance(a, Answer) for a in meant),
            "same": sum(isinstance(a, Answer) and a == b for a, b in pairs),
            "only_read_as": sum(isinstance(b, Answer) and not isinstance(a, Answer) for a, b in pairs),
            "successes": sum(_succeeds(a, one, settings) for a, one in zip(meant, group, strict=True)),
            "successes_read_as": sum(_succeeds(b, one, settings) for b, one in zip(swapped, group, strict=True)),
        }
        rows += [row] if group else []
    return rows


def _succeeds(answer: Predicted, episode: Episode, settings: Settings) -> bool:
    return isinstance(answer, Answer) and is_right((answer.x, answer.z), episode, settings.success.radius_m)


def write_sensitivity(
    admissions_file: Path, episodes_file: Path, arm_file: Path, baseline_file: Path, settings: Settings, output: Path
) -> None:
    """Write the rows of `compute_margins` of comparisons.memory's arm and its baseline, over the trials of the admissions.

    Settings: sensitivity.*, the thresholds of a verdict, success.radius_m, single_visit.samples, benchmark.seed.
    """
    admissions = Admission.read(admissions_file)
    ours, theirs = (_read_success(file, episodes_file, admissions, settings) for file in (arm_file, baseline_file))
    write_csv(output, MARGINS, compute_margins(admissions, ours, theirs, settings))


def write_tolerances(
    trials_file: Path,
    released_file: Path,
    episodes_file: Path,
    arm_file: Path,
    baseline_file: Path,
    settings: Settings,
    output: Path,
) -> None:
    """Write the same with section `tolerances` in the place of `sensitivity`.

    trials_file: all trials of main; released_file: its released episodes; the other files are those of `write_sensitivity`.
    """
    narrow = settings.with_values({f"sensitivity.{name}": getattr(settings.tolerances, name) for name in THRESHOLDS})
    released, places = {one.id for one in Episode.load(released_file)}, settings_of(narrow)
    admissions = [
        Admission(id=trial.candidate.id, settings=numbers, released=trial.candidate.id in released)
        for trial in Trial.read(trials_file)
        if (numbers := admitting(trial, places))
    ]
    ours, theirs = (_read_success(file, episodes_file, admissions, settings) for file in (arm_file, baseline_file))
    write_csv(output, MARGINS, compute_margins(admissions, ours, theirs, narrow))


def _read_success(file: Path, episodes_file: Path, admissions: Sequence[Admission], settings: Settings) -> list[float]:
    """Return the success of an arm's predictions on the trials of the admissions."""
    constants = {"samples": settings.single_visit.samples, "seed": settings.benchmark.seed}
    episodes = Episode.load(episodes_file)
    outcomes = static_outcomes(episodes, Prediction.read(file), radius_m=settings.success.radius_m, **constants)
    by_episode = {outcome.episode: outcome.success for outcome in outcomes}
    return [by_episode[one.id] for one in admissions]


def compute_margins(
    admissions: Sequence[Admission], success: Sequence[float], baseline: Sequence[float], settings: Settings
) -> list[Row]:
    """Compute the margin of memory under the setting in force (number 0), then under every setting of section sensitivity.

    The margin is the success of an arm less that of its baseline, over the trials that a setting admits. The predictions are the
    same under all settings. Only the setting in force was certified, so certification counts under none; `released_margin` is
    over the released episodes, all certified, that a setting leaves.
    """
    places = {name: place.split(".") for name, place in THRESHOLDS.items()}
    in_force = {name: getattr(getattr(settings, section), last) for name, (section, last) in places.items()}
    thresholds = [in_force, *settings.sensitivity.settings()]
    admitted = np.zeros((len(thresholds), len(admissions)), bool)
    for column, one in enumerate(admissions):
        admitted[list(one.settings), column] = True
    released = admitted & np.array([one.released for one in admissions], bool)
    ours, theirs = np.array(success, float), np.array(baseline, float)
    return [
        {
            "setting": number,
            "in_force": number == 0,
            **values,
            "episodes": int(admitted[number].sum()),
            "rate": _mean(ours, admitted[number]),
            "baseline_rate": _mean(theirs, admitted[number]),
            "margin": _mean(ours - theirs, admitted[number]),
            "released": int(released[number].sum()),
            "released_margin": _mean(ours - theirs, released[number]),
        }
        for number, values in enumerate(thresholds)
    ]


def _mean(values: np.ndarray, chosen: np.ndarray) -> float | None:
    return float(values[chosen].mean()) if chosen.any() else None
