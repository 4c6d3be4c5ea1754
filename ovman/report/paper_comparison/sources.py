"""Where the figures of the statements are read: one function a kind of figure, each naming file, row and column."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from scipy.stats import fisher_exact

from ovman.analysis.comparisons import AGENT
from ovman.analysis.difficulty import MANY, By
from ovman.analysis.segmentation import TRUE
from ovman.analysis.taxonomy import LOST, Verdict
from ovman.report.paper_comparison.metrics import Cell, Metrics, Missing
from ovman.task import Relation

Read = Callable[[Metrics], Cell]

ALL = "all"
PAST = tuple(relation.value for relation in Relation if relation.past)
CURRENT = tuple(relation.value for relation in Relation if not relation.past)
RELATIONS = tuple(relation.value for relation in Relation)
TWO_INSTANCES, THREE_INSTANCES, MORE_INSTANCES = "2", "3", f"{MANY}+"
"""Groups of difficulty.csv."""
EPISODES = "episodes"
VISIT = "two visits"
"""Maps of single visits, in dualmap.csv."""


def static(arm: str, relation: str = ALL, column: str = "rate") -> Read:
    """A static arm's success on a relation, or on all episodes."""
    return lambda metrics: metrics.cell("static_rates.csv", column, arm=arm, relation=relation)


def embodied(arm: str, relation: str = ALL, column: str = "rate") -> Read:
    """An embodied arm's success, the mean over its seeds."""
    return lambda metrics: metrics.cell("embodied_rates.csv", column, arm=arm, relation=relation)


def navigated(arm: str, column: str, index: int) -> Read:
    """An embodied arm over all episodes under the index-th of its seeds."""
    return lambda metrics: metrics.cell(
        "navigation.csv", column, arm=arm, relation=ALL, seed=_seed(metrics, "navigation.csv", index, arm=arm, relation=ALL)
    )


def over_seeds(arm: str, column: str) -> Read:
    """The mean of a column of navigation.csv over the seeds of an embodied arm, all episodes."""
    return _mean_over_seeds("navigation.csv", arm, column)


def compared(arm: str, baseline: str, column: str, relation: str = ALL) -> Read:
    """A column of significance.csv, under the first seed that both arms have."""
    where = {"arm": arm, "baseline": baseline, "relation": relation}
    return lambda metrics: metrics.cell("significance.csv", column, **where, seed=_seed(metrics, "significance.csv", 0, **where))


def largest_p(arm: str, baseline: str) -> Read:
    """The largest p over all episodes among the seeds that two arms share."""
    source = f"significance.csv ({arm}, {baseline}, all, largest of the seeds): p"
    return lambda metrics: Cell(max(metrics.numbers("significance.csv", "p", arm=arm, baseline=baseline, relation=ALL)), source)


def of_seeds(arm: str, choose: Callable[[Sequence[float]], float], relation: str = ALL) -> Read:
    """The lowest (min) or highest (max) success of an arm among its seeds or runs, of which there must be several."""

    def read(metrics: Metrics) -> Cell:
        rates = metrics.numbers("seeds.csv", "rate", arm=arm, relation=relation)
        if len(rates) < 2:
            raise Missing(f"seeds.csv has one seed of {arm}, which cannot differ from others")
        seed = metrics.texts("seeds.csv", "seed", arm=arm, relation=relation)[rates.index(value := choose(rates))]
        return Cell(value, f"seeds.csv ({arm}, {relation}, seed {seed}): rate")

    return read


def mean_of_seeds(arm: str, relation: str = ALL) -> Read:
    """The mean success of an arm over its seeds or runs."""
    source = f"seeds.csv ({arm}, {relation}, mean): rate"
    return lambda metrics: Cell(_mean(metrics.numbers("seeds.csv", "rate", arm=arm, relation=relation)), source)


def own_task(arm: str, column: str) -> Read:
    """The mean over the seeds of a column of own_task.csv, all episodes."""
    return _mean_over_seeds("own_task.csv", arm, column)


def own_task_p(arm: str) -> Read:
    """The largest p over all episodes among the seeds of an arm: its own task against this one."""
    source = f"own_task.csv ({arm}, all, largest of the seeds): p"
    return lambda metrics: Cell(max(metrics.numbers("own_task.csv", "p", arm=arm, relation=ALL)), source)


def of_pairings(
    arm: str, baseline: str, choose: Callable[[Sequence[float]], float], column: str = "difference", relation: str = ALL
) -> Read:
    """The lowest (min) or highest (max) of a column of pairings.csv among the pairings of two arms' runs."""

    def read(metrics: Metrics) -> Cell:
        values = metrics.numbers("pairings.csv", column, arm=arm, baseline=baseline, relation=relation)
        words = {min: "lowest", max: "highest"}[choose]
        return Cell(choose(values), f"pairings.csv ({arm}, {baseline}, {relation}, {words} of {len(values)} pairings): {column}")

    return read


def least_p_ahead(arm: str, baseline: str) -> Read:
    """The lowest p over all episodes among the pairings in which the arm is ahead of its baseline; 1 where it is in none."""

    def read(metrics: Metrics) -> Cell:
        where = {"arm": arm, "baseline": baseline, "relation": ALL}
        differences = metrics.numbers("pairings.csv", "difference", **where)
        ahead = [p for p, d in zip(metrics.numbers("pairings.csv", "p", **where), differences, strict=True) if d > 0]
        return Cell(
            min(ahead, default=1.0),
            f"pairings.csv ({arm}, {baseline}, all, lowest of the {len(ahead)} of {len(differences)} pairings with a lead): p",
        )

    return read


def objects(place: int) -> Read:
    """How many objects DualMap's maps of single visits hold in a scene, the mean over runs and visits.

    place: of the scene, among all from the one with the fewest objects (0) to the one with the most (-1).
    """

    def read(metrics: Metrics) -> Cell:
        scenes: dict[str, list[float]] = {}
        counts = metrics.numbers("dualmap.csv", "objects_mean", memory=VISIT)
        for scene, count in zip(metrics.texts("dualmap.csv", "scene", memory=VISIT), counts, strict=True):
            scenes.setdefault(scene, []).append(count)
        ranked = sorted((_mean(of_scene), scene) for scene, of_scene in scenes.items() if scene != ALL)
        if len(ranked) < 3:
            raise Missing(f"dualmap.csv has {len(ranked)} scenes, which is too few to tell one from the others")
        count, scene = ranked[place]
        return Cell(count, f"dualmap.csv ({scene}, {VISIT}, mean over runs): objects_mean")

    return read


def rung(title: str, column: str = "gain") -> Read:
    """A column of a rung of the error budget over all episodes."""
    return lambda metrics: metrics.cell("budget.csv", column, rung=title, relation=ALL)


def outcomes(verdict: str, relation: str = ALL) -> Read:
    """How many episodes of the two-visit agent have a verdict; EPISODES: how many there are.

    What is lost in navigation is counted under the first seed, the other verdicts know none.
    """

    def read(metrics: Metrics) -> Cell:
        file = "taxonomy.csv"
        if verdict == EPISODES:
            return metrics.cell(file, "n", arm=AGENT, verdict=Verdict.SUCCESS.value, relation=relation)
        where = {"arm": AGENT, "verdict": verdict, "relation": relation}
        if verdict == LOST:
            where["seed"] = _seed(metrics, file, 0, **where)
        return metrics.cell(file, "episodes", **where)

    return read


def share(verdict: str, relation: str) -> Read:
    """The share of a relation's episodes that has a verdict."""

    def read(metrics: Metrics) -> Cell:
        count, of = outcomes(verdict, relation)(metrics), outcomes(EPISODES, relation)(metrics)
        if not of.value:
            raise Missing(f"taxonomy.csv has no episodes of {relation}")
        return Cell(count.value / of.value, f"{count.source} / n")

    return read


def with_instances(arm: str, group: str, column: str = "rate") -> Read:
    """A static arm on the episodes whose category has so many instances."""
    return lambda metrics: metrics.cell("difficulty.csv", column, by=By.INSTANCES.value, group=group, arm=arm)


def falling_p(arm: str) -> Read:
    """One-sided p of Fisher's exact test that success with two instances of the category exceeds that with the most."""

    def read(metrics: Metrics) -> Cell:
        table = []
        for group in (TWO_INSTANCES, MORE_INSTANCES):
            won = with_instances(arm, group, "successes")(metrics).value
            n = with_instances(arm, group, "n")(metrics).value
            if not 0 <= won <= n:
                raise ValueError(f"difficulty.csv ({arm}, {group} instances): {won:g} successes of {n:g}; make the metrics again")
            table.append([round(won), round(n - won)])
        p = fisher_exact(table, alternative="greater").pvalue
        return Cell(float(p), f"difficulty.csv ({arm}, {TWO_INSTANCES} against {MORE_INSTANCES} instances): successes, n")

    return read


def of_scenes(arm: str, choose: Callable[[Sequence[float]], float]) -> Read:
    """The lowest (min) or highest (max) success of a static arm among the scenes."""

    def read(metrics: Metrics) -> Cell:
        where = {"by": By.SCENE.value, "arm": arm}
        rates = metrics.numbers("difficulty.csv", "rate", **where)
        scene = metrics.texts("difficulty.csv", "group", **where)[rates.index(value := choose(rates))]
        return Cell(value, f"difficulty.csv ({scene}, {arm}): rate")

    return read


def worst_m(column: str) -> Read:
    """The largest error of the self-check of the back-projection, in metres, over all true masks."""
    source = f"backprojection.csv (true masks): greatest {column}"
    return lambda metrics: Cell(max(metrics.numbers("backprojection.csv", column, mask=TRUE)), source)


def self_checked(*columns: str) -> Read:
    """How many distinct objects, or scenes, the self-check of the back-projection saw: values of these columns together."""

    def read(metrics: Metrics) -> Cell:
        values = [metrics.texts("backprojection.csv", column, mask=TRUE) for column in columns]
        return Cell(float(len(set(zip(*values, strict=True)))), f"backprojection.csv (true masks): distinct {', '.join(columns)}")

    return read


def language(what: str, column: str = "rate") -> Read:
    """A rate over all held-out sentences, or over the episodes that they are about."""
    return lambda metrics: metrics.cell("language.csv", column, what=what, relation=ALL)


def less(greater: Read, lesser: Read) -> Read:
    """The first figure minus the second."""

    def read(metrics: Metrics) -> Cell:
        first, second = greater(metrics), lesser(metrics)
        return Cell(first.value - second.value, f"{first.source} − {second.source}")

    return read


def mean(figures: Sequence[Read]) -> Read:
    """The mean of several figures."""

    def read(metrics: Metrics) -> Cell:
        cells = [figure(metrics) for figure in figures]
        return Cell(_mean([cell.value for cell in cells]), f"mean of {'; '.join(cell.source for cell in cells)}")

    return read


def lowest(figures: Sequence[Read]) -> Read:
    """The lowest of several figures."""
    return lambda metrics: min((figure(metrics) for figure in figures), key=lambda cell: cell.value)


def highest(figures: Sequence[Read]) -> Read:
    """The highest of several figures."""
    return lambda metrics: max((figure(metrics) for figure in figures), key=lambda cell: cell.value)


def _mean_over_seeds(file: str, arm: str, column: str) -> Read:
    source = f"{file} ({arm}, all, mean over seeds): {column}"
    return lambda metrics: Cell(_mean(metrics.numbers(file, column, arm=arm, relation=ALL)), source)


def _seed(metrics: Metrics, file: str, index: int, **where: str) -> str:
    """The index-th of the seeds, by number, of the rows of `where`."""
    seeds = sorted(set(metrics.texts(file, "seed", **where)), key=int)
    if index >= len(seeds):
        raise Missing(f"{file} has {len(seeds)} of the {index + 1} seeds of {', '.join(where.values())} that are needed")
    return seeds[index]


def _mean(values: Sequence[float]) -> float:
    return sum(values) / len(values)
