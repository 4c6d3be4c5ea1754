"""The metrics of one split: from episodes, predictions and judged runs to outcomes, rates, tests and breakdowns."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ovman.analysis import breakdowns, comparisons, navigation
from ovman.analysis.bounds import BOUNDS, bounds
from ovman.analysis.outcomes import EMBODIED_OUTCOMES, STATIC_OUTCOMES, Outcome, embodied_outcomes, group_by, static_outcomes
from ovman.analysis.rates import RATES, arm_rates, rates
from ovman.analysis.rows import write_csv
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Score
from ovman.settings import Arm, Kind, Settings


def write_metrics(
    episodes_file: Path, prediction_files: Sequence[Path], score_files: Sequence[Path], settings: Settings, directory: Path
) -> None:
    """Write one csv file per metric of a split into a directory; `ovman.analysis.registry` lists them.

    Rows are in the order of the arms, then seeds, then episodes, whatever the order of the files. Pairs of arms of which one has
    no records are left out.

    Settings: arms, comparisons.{rungs,pairs,pairings,readings}, success.radius_m, single_visit.samples, benchmark.seed,
    evaluation.{confidence,near_miss_m}, candidates.delta_min_m.

    Raises:
        ValueError: Records are missing or do not fit the arms; one line with the file, arm or episode, and the remedy.
    """
    episodes, arms = Episode.load(episodes_file), settings.arms
    confidence, radius_m = settings.evaluation.confidence, settings.success.radius_m
    predictions = [one for path in prediction_files for one in _read_predictions(path, bool(episodes), arms)]
    scores = [one for path in score_files for one in Score.read(path)]
    constants = {"samples": settings.single_visit.samples, "seed": settings.benchmark.seed}
    answers = static_outcomes(episodes, predictions, radius_m=radius_m, **constants)
    static = _in_order(Kind.STATIC, answers, episodes, arms)
    embodied = _in_order(Kind.EMBODIED, embodied_outcomes(episodes, scores), episodes, arms)
    _check_runs(static, arms)
    stream = episodes_file.stem
    static_rates = arm_rates(static, confidence, stream)
    both = [*static, *embodied]
    compared = comparisons.significance(both, settings.comparisons.pairs.values(), stream)
    paired = comparisons.pairings(static, settings.comparisons.pairings.values(), stream)
    navigations = navigation.navigation(static, embodied, arms, radius_m)
    near_miss_m = settings.evaluation.near_miss_m
    tables: Mapping[str, tuple[str, Sequence[object]]] = {
        "static_outcomes": (STATIC_OUTCOMES, static),
        "embodied_outcomes": (EMBODIED_OUTCOMES, embodied),
        "static_rates": (RATES, static_rates),
        "embodied_rates": (RATES, arm_rates(embodied, confidence, stream)),
        "significance": (comparisons.COMPARISONS, compared),
        "pairings": (comparisons.PAIRINGS, paired),
        "navigation": (navigation.NAVIGATION, navigations),
        "rescued": (navigation.RESCUED, navigation.rescued(navigations)),
        "own_task": (navigation.OWN_TASK, navigation.own_task(embodied)),
        "mover": (navigation.MOVER, navigation.mover_distances(episodes, radius_m, settings.candidates.delta_min_m)),
        "scenes": (breakdowns.SCENES, rates(both, ("kind", "arm", "scene"), confidence)),
        "seeds": (breakdowns.SEEDS, breakdowns.seed_rates(both, confidence)),
        "difficulty": (breakdowns.DIFFICULTY, breakdowns.difficulty(static, confidence)),
        "shortcuts": (breakdowns.SHORTCUTS, breakdowns.shortcuts(both, radius_m)),
        "taxonomy": (breakdowns.TAXONOMY, breakdowns.taxonomy(static, navigations, radius_m, near_miss_m)),
        "budget": (breakdowns.BUDGET, breakdowns.budget(static_rates, compared, settings.comparisons.rungs)),
        "bounds": (BOUNDS, bounds(both, episodes, arms, confidence)),
        "words": (breakdowns.WORDS, breakdowns.words(both, episodes, arms, confidence)),
        "readings": (breakdowns.READINGS, breakdowns.readings(static, arms, settings.comparisons.readings, confidence)),
    }
    directory.mkdir(parents=True, exist_ok=True)
    for name, (columns, rows) in tables.items():
        write_csv(directory / f"{name}.csv", columns, rows)


def _read_predictions(path: Path, has_episodes: bool, arms: Mapping[str, Arm]) -> list[Prediction]:
    predictions = Prediction.read(path)
    # A plug-in that lacks something leaves an empty file and a note for the tables.
    by_plugin = path.stem in arms and arms[path.stem].made_by is not None
    # Without this check an arm that broke off before its first answer would leave the tables silently.
    if has_episodes and not predictions and not by_plugin:
        raise ValueError(f"{path}: has no predictions; make the file again")
    return predictions


def _in_order(kind: Kind, outcomes: Sequence[Outcome], episodes: Sequence[Episode], arms: Mapping[str, Arm]) -> list[Outcome]:
    names = [name for name, arm in arms.items() if arm.kind is kind]
    if strangers := sorted({outcome.arm for outcome in outcomes} - {*names}):
        raise ValueError(f"{strangers[0]!r} is not an arm that is {kind}; the arms are {', '.join(names)}")
    arm_place = {name: number for number, name in enumerate(names)}
    episode_place = {one.id: number for number, one in enumerate(episodes)}
    return sorted(outcomes, key=lambda one: (arm_place[one.arm], one.seed, episode_place[one.episode]))


def _check_runs(outcomes: Sequence[Outcome], arms: Mapping[str, Arm]) -> None:
    for name, of_arm in group_by(outcomes, "arm").items():
        if (runs := len(group_by(of_arm, "seed"))) != arms[name].runs:
            raise ValueError(
                f"{name}: predictions of {runs} runs, but its entry in section arms says {arms[name].runs}; "
                "make its predictions again"
            )
