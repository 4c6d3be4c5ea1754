"""Values of settings that contradict each other although each is allowed."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import pairwise

from ovman.settings.arms import Arm, Kind, Need, Source, Track, Withheld
from ovman.settings.comparisons import THRESHOLDS
from ovman.settings.settings import Settings, matching
from ovman.settings.splits import MAIN

Contradiction = tuple[tuple[str, ...], str]
"""The place of a setting, and what is wrong with its value and what to do."""


FOREIGN = {Kind.EMBODIED: ("expected", "runs", "withheld"), Kind.STATIC: ("executes", "embodiment", "budget", "cut_from")}
"""Fields that are not for an arm of a kind."""


def contradictions(settings: Settings) -> Iterator[Contradiction]:
    """Yield values that contradict each other."""
    for check in CHECKS:
        yield from check(settings)


def _of_measurement(settings: Settings) -> Iterator[Contradiction]:
    """Yield bounds of measurement that are stricter than a verdict: the one in force, or one of section `sensitivity`."""
    constants = settings.constants()
    for name, bound, strictest, word in (
        ("min_mask_px", "min_mask_px", min, "at most"),
        ("visible_px", "visible_px", min, "at most"),
        ("validity_radius_m", "answer_to_navigable_m", max, "at least"),
    ):
        limit = constants[f"measurement.{bound}"]
        in_force, swept = THRESHOLDS[name], f"sensitivity.{name}"
        for place, values in ((in_force, [constants[in_force]]), (swept, constants[swept])):
            if (value := strictest(values)) != limit and strictest(value, limit) == value:
                says = f"measurement.{bound} must be {word} that and is {limit}; change one of the two"
                yield tuple(place.split(".")), f"is {value}, but {says}"


def _of_counts(settings: Settings) -> Iterator[Contradiction]:
    """Yield splits with more episodes than candidates, and main if it is crossed."""
    for name, split in settings.splits.items():
        scenes = len(split.places)
        for relation, episodes in split.episodes:
            if episodes > (draws := getattr(split.draws, relation)) * scenes:
                says = f"splits.{name}.draws.{relation} x scenes are {draws} x {scenes} = {draws * scenes}; lower it or draw more"
                yield ("splits", name, "episodes", relation), f"is {episodes}, but {says}"
    if settings.splits[MAIN].crossed is not None:
        yield ("splits", MAIN, "crossed"), "is given, but main follows the paper; draw world pairs for another split"


def _of_motion(settings: Settings) -> Iterator[Contradiction]:
    """Yield turns with which the agent cannot face every direction, and windows that are never full."""
    turn, tolerance = settings.primitives.turn_deg, settings.primitives.heading_tolerance_deg
    if 360.0 % turn:
        yield ("primitives", "turn_deg"), f"is {turn}, which does not divide 360; write a divisor of 360, such as 30"
    elif tolerance < turn / 2:
        says = f"half of primitives.turn_deg ({turn}): some headings could not be reached; write at least {turn / 2}"
        yield ("primitives", "heading_tolerance_deg"), f"is {tolerance}, which is less than {says}"
    local = settings.dualmap.local_map
    if local.split_frames >= local.split_window:
        says = f"the {local.split_window} keyframes of dualmap.local_map.split_window never hold more; lower it"
        yield ("dualmap", "local_map", "split_frames"), f"is {local.split_frames}, but {says}"


def _of_arms(settings: Settings) -> Iterator[Contradiction]:
    """Yield arms that name settings, plug-ins or other arms that do not exist, and fields that are not for their kind."""
    arms, plugins, names = settings.arms, settings.plugins, settings.constants()
    for name, arm in arms.items():
        if arm.made_by is not None and arm.made_by not in plugins:
            says = f"which is not in section plugins; the plug-ins are {', '.join(plugins) or 'none'}"
            yield ("arms", name, "made_by"), f"is {arm.made_by}, {says}"
        for pattern in arm.constants:
            if not matching([pattern], names) or pattern == "arms":
                yield ("arms", name, "constants"), f'names {pattern}, which is not a setting; write "section.name" or "section.*"'
        for field in FOREIGN[arm.kind]:
            if getattr(arm, field) != Arm.model_fields[field].default:
                yield ("arms", name, field), f"is not for an arm that is {arm.kind}; take it out"
        for field, kind in (("executes", Kind.STATIC), ("cut_from", Kind.EMBODIED)):
            other = getattr(arm, field)
            if other is not None and (other not in arms or arms[other].kind is not kind):
                yield ("arms", name, field), f"is {other}, which is not a known {kind} arm; name one"
        whole = None if arm.cut_from is None else arms.get(arm.cut_from)
        if whole is not None and not _can_be_cut(whole, arm):
            says = "from whose runs it cannot be cut; name an arm that drives itself, for no fewer actions than `budget`"
            yield ("arms", name, "cut_from"), f"is {arm.cut_from}, {says}"


def _can_be_cut(whole: Arm, arm: Arm) -> bool:
    """Return whether the runs of `whole` contain those of `arm`, which end after fewer actions."""
    return whole.cut_from is None and arm.budget is not None and (whole.budget is None or whole.budget >= arm.budget)


def _of_withheld(settings: Settings) -> Iterator[Contradiction]:
    """Yield contradictions between `withheld` and the rest of an arm's entry."""
    for name, arm in settings.arms.items():
        executed = settings.arms.get(arm.executes or "")
        if executed is not None and executed.withheld is not None:
            says = f"from which {executed.withheld} is withheld, and from an embodied arm nothing is; name another"
            yield ("arms", name, "executes"), f"is {arm.executes}, {says}"
        place, withheld = ("arms", name, "withheld"), arm.withheld
        if withheld is not None and arm.made_by is not None:
            yield place, f"is {withheld}, but plug-in {arm.made_by} asks the arm; take it out"
        if withheld in (Withheld.NOUN, Withheld.NOUN_WRONG) and Source.HANDED in (arm.grounding, arm.positions, arm.answer):
            yield place, f"is {withheld}, but the arm is handed what the noun means; write grounding: own and positions: own"
        of_both = {Need.MAINTAINED, Need.DUALMAP, Need.SEGMENTS} & {*arm.needs}
        if withheld is not None and withheld.visit is not None and of_both:
            yield place, f"is {withheld}, but {min(of_both)} is made of both visits; name an arm that needs maps or tours"


def _of_tracks(settings: Settings) -> Iterator[Contradiction]:
    """Yield arms of the words track that are told more than words, and arms that execute one of another track."""
    for name, arm in settings.arms.items():
        executed, place = settings.arms.get(arm.executes or ""), ("arms", name, "track")
        if executed is not None and executed.track is not arm.track:
            yield place, f"is {arm.track}, but that of {arm.executes}, which the arm executes, is {executed.track}; name another"
        if arm.track is Track.WORDS and Source.HANDED in (arm.grounding, arm.positions, arm.answer):
            yield place, "is words, but the arm is handed what the words mean; write grounding: own and positions: own"
        if arm.track is Track.WORDS and arm.made_by is not None:
            yield place, f"is words, but plug-in {arm.made_by} asks the arm; take it out"


def _of_comparisons(settings: Settings) -> Iterator[Contradiction]:
    """Yield arms in section `comparisons` that do not fit the place that names them."""
    comparisons, arms = settings.comparisons, settings.arms
    static = [name for name, arm in arms.items() if arm.kind is Kind.STATIC]
    if comparisons.agent not in static:
        yield ("comparisons", "agent"), f"is {comparisons.agent}, which is not a static arm; name one"
    for role, name in comparisons.memory:
        if name not in static:
            yield ("comparisons", "memory", role), f"is {name}, which is not a static arm; name one"
        elif {*arms[name].needs} - {Need.MAPS} or _is_another_game(arms[name]):
            says = "name an arm that needs maps at most, is handed nothing, is withheld nothing and runs once"
            yield ("comparisons", "memory", role), f"is {name}; {says}"
    for section in ("rungs", "readings", "difficulty", "shortcuts"):
        for name in getattr(comparisons, section):
            if name in arms and name not in static:
                yield ("comparisons", section, name), "is an embodied arm; name a static one"
    for title, system in comparisons.overview.items():
        for kind in Kind:
            arm = getattr(system, kind)
            if arm in arms and arms[arm].kind is not kind:
                yield ("comparisons", "overview", title, kind), f"is {arm}, which is not an arm of kind {kind}; name one"
    roles = [entry.role for entry in comparisons.controls.values() if entry.role]
    for name, entry in comparisons.controls.items():
        if roles.count(entry.role) > 1:
            yield ("comparisons", "controls", name, "role"), f"is {entry.role}, which is that of another entry, too; rename one"


def _is_another_game(arm: Arm) -> bool:
    """Return whether an arm is given more or less than an agent is, or has several runs."""
    return arm.reads_sightings or arm.reads_labels or arm.runs > 1 or arm.withheld is not None


def _of_pairs(settings: Settings) -> Iterator[Contradiction]:
    """Yield rungs that no pair tests against each other, and pairs of arms that no test compares."""
    comparisons, arms = settings.comparisons, settings.arms
    tested = {(pair.arm, pair.baseline) for pair in comparisons.pairs.values()}
    for lower, upper in pairwise(comparisons.rungs):
        if (upper, lower) not in tested:
            says = f"follows {lower}, but no entry of comparisons.pairs tests {upper} against {lower}; add it"
            yield ("comparisons", "rungs", upper), says
    for section, pairs in (("pairs", comparisons.pairs), ("pairings", comparisons.pairings)):
        for title, pair in pairs.items():
            place = ("comparisons", section, title)
            kinds = {arms[name].kind for name in (pair.arm, pair.baseline) if name in arms}
            if len(kinds) > 1:
                yield place, f"compares {pair.arm} with {pair.baseline}, of which one is static and one embodied"
            if section == "pairings" and Kind.EMBODIED in kinds:
                yield place, "has an embodied arm; pairings are of static arms, write it under comparisons.pairs"
            if pair.arm in arms and arms[pair.arm].expected:
                yield place, f"tests {pair.arm}, a stochastic pick; no exact test does, name it as the baseline"


def _of_splits(settings: Settings) -> Iterator[Contradiction]:
    """Yield arms that answer main alone in other splits, and scenes shared by splits that are toured apart.

    An arm that does not exist is left out of its splits, too.
    """
    arms = settings.arms
    # A crossed split in floor plans compares agents across splits; its scenes are not kept apart from development.
    apart = [split for split in settings.splits.values() if split.in_main_job and (split.plain or split.homes is not None)]
    job = {scene for split in apart for scene in split.places}
    for name, split in settings.splits.items():
        for number, arm in enumerate(split.arms if name != MAIN else ()):
            if arm in arms and (arms[arm].made_by is not None or Need.DUALMAP in arms[arm].needs):
                says = f"is {arm}, whose records are made of split {MAIN} alone; name another arm"
                yield ("splits", name, "arms", str(number)), says
        if not split.in_main_job and (shared := sorted(job & {*split.places})):
            says = f"but {shared[0]} is a scene of the main job; name other scenes, or set in_main_job to true"
            yield ("splits", name, "in_main_job"), f"is false, {says}"


def _of_thresholds(settings: Settings) -> Iterator[Contradiction]:
    """Yield thresholds that make Eq. 1 contradict itself, and tolerances that admit trials beyond those of `sensitivity`."""
    if (tau_m := max(settings.sensitivity.tau_m)) >= (delta_m := min(settings.sensitivity.delta_min_m)):
        says = f"has {tau_m}, but delta_min_m has {delta_m}: an instance would be stable and moved at once"
        yield ("sensitivity", "tau_m"), says
    for name in THRESHOLDS:
        wide, narrow = getattr(settings.sensitivity, name), getattr(settings.tolerances, name)
        if min(narrow) < min(wide) or max(narrow) > max(wide):
            yield ("tolerances", name), f"leaves the range of sensitivity.{name}, {min(wide)} to {max(wide)}; narrow it"


def _of_appearance(settings: Settings) -> Iterator[Contradiction]:
    arm = settings.arms.get(settings.appearance.agent)
    if arm is None or arm.kind is not Kind.STATIC or Need.MAPS not in arm.needs or arm.expected:
        says = "which is not a static arm that answers from maps of both visits; name one"
        yield ("appearance", "agent"), f"is {settings.appearance.agent}, {says}"


CHECKS: tuple[Callable[[Settings], Iterator[Contradiction]], ...] = (
    *(_of_measurement, _of_counts, _of_motion, _of_arms, _of_withheld, _of_tracks, _of_comparisons, _of_pairs),
    *(_of_splits, _of_thresholds, _of_appearance),
)
