"""The stage "metrics": from episodes, predictions and judged runs to one row an (episode, arm, seed) and to rates."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.budget import Step, budget
from ovman.analysis.difficulty import Difficulty, difficulty
from ovman.analysis.mover import MoverDistance, mover
from ovman.analysis.navigation import Navigation, navigation
from ovman.analysis.outcomes import Case, EmbodiedOutcome, StaticOutcome, embodied_outcomes, judged, read_cases
from ovman.analysis.own_task import OwnTask, own_task
from ovman.analysis.pairings import Pairing, pairings
from ovman.analysis.rates import Rate, by_arm, by_seed, embodied_rates, static_rates
from ovman.analysis.readings import HandedOver, readings
from ovman.analysis.registry import of_stage
from ovman.analysis.rescued import Rescued, rescued
from ovman.analysis.scenes import SceneRate, scenes
from ovman.analysis.shortcuts import Shortcut, shortcuts
from ovman.analysis.significance import Comparison, significance
from ovman.analysis.spread import Pass, passes
from ovman.analysis.taxonomy import TaxonomyCount, taxonomy
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Score
from ovman.settings import Arm, Kind, Settings, arms_of

STATIC_OUTCOMES, EMBODIED_OUTCOMES = "static_outcomes.csv", "embodied_outcomes.csv"


def run(
    episodes_file: Path,
    prediction_files: Sequence[Path],
    run_files: Sequence[Path],
    constants: Settings,
    output_dir: Path,
    arms: Sequence[Arm] | None = None,
) -> None:
    """Writes the files of the registry's stage "metrics" into output_dir, made if need be. Either list of files may be empty.

    Rows are in the order of the arms' table, then of the seeds, then of the episodes, whatever the order of the files. Numbers
    have six decimals, p-values six digits, counts none, what does not apply is empty. Pairs of arms of which one does not exist
    are not compared, and a line says so.

    arms: all arms; those of `constants` if not given; a list of files that is not empty has all arms of its kind.
    constants: arms, comparisons, success.radius_m,
    single_visit.samples, benchmark.seed, evaluation.confidence, evaluation.near_miss_m, candidates.delta_min_m.
    Raises ValueError in one line that names the file, the arm or the episode and the remedy.
    """
    arms = arms_of(constants.arms) if arms is None else arms
    cases = read_cases(episodes_file)
    predictions = [record for path in prediction_files for record in _predictions(path, cases, arms)]
    runs = [run for path in run_files for run in Score.read(path)]
    static = judged(cases, predictions, constants)
    embodied = embodied_outcomes(cases, runs)
    _whole(Kind.STATIC, static, arms)
    _whole(Kind.EMBODIED, embodied, arms)
    _every_run(static, arms)
    place = {case.id: index for index, case in enumerate(cases)}
    names = [arm.name for arm in arms]

    def order(outcome: StaticOutcome | EmbodiedOutcome) -> tuple[int, int, int]:
        return names.index(outcome.arm), outcome.seed, place[outcome.episode]

    static, embodied = sorted(static, key=order), sorted(embodied, key=order)
    confidence, radius = constants.evaluation.confidence, constants.success.radius_m
    rates = static_rates(static, confidence)
    compared, left_out = significance(static, embodied, constants.comparisons.pairs.values())
    paired, unpaired = pairings(static, constants.comparisons.pairings.values())
    navigations = navigation(static, embodied, arms)
    for line in (*left_out, *unpaired):
        print(line, flush=True)
    output_dir.mkdir(parents=True, exist_ok=True)
    made: dict[str, str] = {
        "static_outcomes": frames.csv_text(StaticOutcome, static),
        "embodied_outcomes": frames.csv_text(EmbodiedOutcome, embodied),
        "static_rates": frames.csv_text(Rate, rates),
        "embodied_rates": frames.csv_text(Rate, embodied_rates(embodied, confidence)),
        "taxonomy": frames.csv_text(TaxonomyCount, taxonomy(static, navigations, radius, constants.evaluation.near_miss_m)),
        "significance": frames.csv_text(Comparison, compared),
        "navigation": frames.csv_text(Navigation, navigations),
        "difficulty": frames.csv_text(Difficulty, difficulty(static, confidence)),
        "budget": frames.csv_text(Step, budget(rates, compared, constants.comparisons.rungs)),
        "readings": frames.csv_text(HandedOver, readings(static, arms, constants.comparisons.readings, confidence)),
        "pairings": frames.csv_text(Pairing, paired),
        "shortcuts": frames.csv_text(Shortcut, shortcuts(cases, static, embodied, radius)),
        "own_task": frames.csv_text(OwnTask, own_task(embodied)),
        "seeds": frames.csv_text(Pass, passes(static, embodied)),
        "rescued": frames.csv_text(Rescued, rescued(static, runs, arms, radius)),
        "scenes": frames.csv_text(SceneRate, scenes(static, embodied, confidence)),
        "mover": frames.csv_text(MoverDistance, mover(Episode.load(episodes_file), radius, constants.candidates.delta_min_m)),
    }
    for name in of_stage("metrics"):
        (output_dir / f"{name}.csv").write_text(made[name], encoding="utf-8", newline="\n")


def _whole(kind: Kind, outcomes: Sequence[StaticOutcome | EmbodiedOutcome], arms: Sequence[Arm]) -> None:
    there = {outcome.arm for outcome in outcomes}
    names = [arm.name for arm in arms if arm.kind is kind]
    if strangers := sorted(there - set(names)):
        raise ValueError(f"{strangers[0]!r} is not an arm that is {kind}; there are {', '.join(names)}")
    if there and (absent := [name for name in names if name not in there and name not in _may_lack(arms)]):
        raise ValueError(f"no records of the {kind} arm {absent[0]!r}; make them, or take it out of the arms' table")


def _may_lack(arms: Sequence[Arm]) -> set[str]:
    """Arms that a plug-in makes: where something is missing for it, it leaves empty records and a note for the tables."""
    return {arm.name for arm in arms if arm.made_by is not None}


def _every_run(outcomes: Sequence[StaticOutcome], arms: Sequence[Arm]) -> None:
    runs = {name: len(by_seed(of_arm)) for name, of_arm in by_arm(outcomes).items()}
    for arm in arms:
        if arm.name in runs and runs[arm.name] != arm.runs:
            raise ValueError(
                f"{arm.name}: predictions of {runs[arm.name]} runs, but its entry in section arms says {arm.runs}; "
                "make its predictions again"
            )


def _predictions(path: Path, cases: Sequence[Case], arms: Sequence[Arm]) -> list[Prediction]:
    answered = Prediction.read(path)
    if not answered and path.stem in _may_lack(arms):
        return []
    # Without this an arm that broke off before its first answer would leave the tables as silently as one that does not exist.
    if cases and not answered:
        raise ValueError(f"{path}: no predictions for {len(cases)} episodes; make the file again")
    return answered
