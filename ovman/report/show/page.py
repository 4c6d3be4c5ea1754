"""The page about one episode: the query, the answers of the arms, and the truth. One self-contained HTML file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby, pairwise, zip_longest
from typing import Any, TypeVar

from jinja2 import Environment, PackageLoader, StrictUndefined

from ovman.agents.interface import VISITS
from ovman.records.episode import Episode
from ovman.records.geometry import Point, Position
from ovman.records.scene import Change
from ovman.report.show.filmstrip import Stand, stands
from ovman.report.show.plan import DEEP, PALE, beyond, overlay_plan, visit_plan
from ovman.report.show.reasoning import Reasoning, reasonings
from ovman.report.show.results import Results
from ovman.report.show.room import Room
from ovman.report.show.verdicts import Drive, embodied_rows, static_rows, stop_of
from ovman.settings import Settings


def environment() -> Environment:
    """The environment of the templates beside this module; all values are escaped except drawings of this package."""
    return Environment(
        loader=PackageLoader("ovman.report.show", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def page(results: Results, episode_id: str, settings: Settings, drives: Sequence[Drive] = ()) -> str:
    """Return the page about an episode as HTML; equal files give equal text.

    drives: the user's own runs of the episode. ShowError for an unknown episode or a missing scene; the page names other missing
    files.
    """
    (name,) = results.chosen([episode_id])
    episode = results.episodes[name]
    room = Room(results.scene(episode.scene), episode)
    found = reasonings(results, episode, settings)
    static, embodied = static_rows(results, episode), embodied_rows(results, episode)
    tours = [_tour(results, episode, found, visit) for visit in (0, 1)]
    shown = shown_at_first(settings)
    pointing = _at_first([list(rows) for _, rows in groupby(static, key=lambda row: row.arm.name)], shown)
    by_agent = {name: [drive for drive in drives if drive.run.arm == name] for name in dict.fromkeys(d.run.arm for d in drives)}
    own = [(name, [stop_of(drive.run, episode.relation.past) for drive in runs]) for name, runs in by_agent.items()]
    answered = any(row.outcome is not None for row in static) or any(row.stops for row in embodied)
    return (
        environment()
        .get_template("page.html")
        .render(
            episode=episode,
            relation=episode.relation,
            changes=[(change.instance, _change(change)) for change in episode.scripted],
            others=[(change.instance, _change(change)) for change in episode.others],
            answer=episode.answer,
            reasonings=[_evidence(reasoning) for reasoning in found],
            evidence=next((k for k, one in enumerate(found) if one.arm == settings.comparisons.agent), 0),
            plans=[visit_plan(room, found, visit) for visit in (0, 1)],
            beyond=[max((beyond(room, reasoning, visit) for reasoning in found), default=0) for visit in (0, 1)],
            overlay=overlay_plan(room, found, static, embodied, by_agent, shown, settings.success.radius_m),
            static=pointing,
            several=[any(row.run is not None for rows in part for row in rows) for part in pointing],
            embodied=_at_first([[row] for row in embodied], shown),
            own=own,
            answered=answered,
            own_task=any(stop.own_task for stops in (*(row.stops for row in embodied), *(of for _, of in own)) for stop in stops),
            arms=[*(row.arm.name for row in static), *(row.arm.name for row in embodied)],
            shown=shown,
            tours=tours,
            rows=_rows(tours),
            absent=_absent(results, episode, found, answered),
            settings=settings,
            similarities=_similarities(found),
            colours=["#{:02x}{:02x}{:02x}".format(*colour) for colour in (PALE, DEEP)],
            command=results.command(episode.split),
        )
    )


def shown_at_first(settings: Settings) -> dict[str, str]:
    """Return the reference agent and the joint agent, on paper and driving: titles of the overview by the arms' names."""
    comparisons = settings.comparisons
    agents = {comparisons.agent, *(name for name, entry in comparisons.controls.items() if entry.role == "joint")}
    systems = {title: system for title, system in comparisons.overview.items() if system.static in agents}
    return {arm: title for title, system in systems.items() for arm in (system.static, system.embodied) if arm is not None}


Rows = TypeVar("Rows", bound=Sequence[Any])


def _at_first(arms: Sequence[Rows], shown: Mapping[str, str]) -> tuple[list[Rows], list[Rows]]:
    """Split the rows of arms into those that are visible at first and the others."""
    parts: tuple[list[Rows], list[Rows]] = [], []
    for rows in arms:
        parts[rows[0].arm.name not in shown].append(rows)
    return parts


def _tour(results: Results, episode: Episode, found: Sequence[Reasoning], visit: int) -> list[Stand]:
    which = VISITS[visit]
    directory = results.visit_directory(episode, which)
    recorded = results.visit(directory)
    if recorded is None:
        return []
    return stands(recorded, directory, episode, results.detected(episode, which), found, visit)


def _rows(tours: Sequence[Sequence[Stand]]) -> list[tuple[Stand | None, Stand | None]]:
    """The waypoints of both tours side by side."""
    first, second = tours
    return list(zip_longest(first, second))


def _change(change: Change) -> str:
    """A change in words."""

    def at(point: Position | Point | None) -> str:
        x, z = (point.x, point.z) if isinstance(point, Position) else point or (math.nan, math.nan)
        return f"({x:.2f}, {z:.2f})"

    before, after, path = change.before, change.after, change.path
    if change.kind == "enable":
        return f"was added at {at(after)}"
    if change.kind == "disable":
        return f"was taken away from {at(before)}"
    if path:
        length = sum(math.dist(one, other) for one, other in pairwise(path))
        return f"moved during the second tour, {length:.2f} m from {at(path[0])} to {at(path[-1])}"
    away = math.nan if before is None or after is None else math.dist((before.x, before.z), (after.x, after.z))
    return f"was put from {at(before)} to {at(after)}, {away:.2f} m away"


def _evidence(reasoning: Reasoning) -> dict[str, Any]:
    """The tables about a reasoning below the overlay."""
    pairs = sorted(reasoning.pairs, key=lambda pair: (pair.cost_m, pair.first, pair.second))
    return {
        "arm": reasoning.arm,
        "title": reasoning.title,
        "own_maps": reasoning.own_maps,
        "pairs": pairs,
        "unmatched": [
            sorted(reasoning.unmatched(v), key=lambda i: (-(i.nearest_m if i.nearest_m is not None else float("inf")), i.id))
            for v in (0, 1)
        ],
        "objects": [len(items) for items in reasoning.items],
        "grounded": [len(reasoning.grounded(v)) for v in (0, 1)],
    }


def _similarities(found: Sequence[Reasoning]) -> tuple[float, float] | None:
    """The least and the greatest similarity of the drawn objects."""
    known = [i.similarity for r in found for items in r.items for i in items if i.similarity is not None]
    return (min(known), max(known)) if known else None


def _absent(results: Results, episode: Episode, found: Sequence[Reasoning], answered: bool) -> list[str]:
    """Sentences about missing files, each with the command that makes them."""

    def of_scene(folder: str, suffix: str) -> str:
        return f"“snakemake --cores 2 -- results/{folder}/{episode.scene}.{suffix}”"

    missing = []
    if any(results.visit(results.visit_directory(episode, which)) is None for which in VISITS):
        missing.append(f"No recorded tours here: {of_scene('visits', 'json')} records them.")
    elif any(results.detected(episode, which) is None for which in VISITS):
        missing.append(f"No detections here: {of_scene('detections', 'npz')} makes them.")
    if any(results.map(episode, which) is None for which in VISITS):
        missing.append(f"No maps here: {of_scene('maps', 'npz')} makes them.")
    elif episode.noun not in results.nouns:
        missing.append(f"No embedding of “{episode.noun}” here, so no similarities: “snakemake -- results/nouns.npz” makes it.")
    if not answered:
        missing.append(f"No arm’s answers on the split {episode.split} here: “{results.command(episode.split)}” makes them.")
    elif not found:
        missing.append(f"No evidence of any arm here: “{results.command(episode.split)}” records it.")
    return missing
