"""Write the page about an episode, one self-contained HTML file, and an index of such pages."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import groupby, pairwise, zip_longest
from pathlib import Path
from typing import Any, TypeVar

from jinja2 import Environment, PackageLoader, StrictUndefined

from ovman.agents.interface import VISITS
from ovman.records.episode import Episode
from ovman.records.geometry import Point, Position
from ovman.records.scene import Change
from ovman.report.show.answers import Drive, describe_stop, list_embodied, list_static
from ovman.report.show.plan import DEEP, PALE, count_beyond, draw_overlay, draw_visit
from ovman.report.show.reasoning import Reasoning, collect_reasonings
from ovman.report.show.results import Results
from ovman.report.show.tours import Stand, show_tour
from ovman.settings import Settings

Rows = TypeVar("Rows", bound=Sequence[Any])


def environment() -> Environment:
    """Return the environment of the templates of this package; all values are escaped except drawings of this package."""
    loader = PackageLoader("ovman.report.show", "templates")
    return Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)


def page(results: Results, name: str, settings: Settings, drives: Sequence[Drive] = ()) -> str:
    """Return the page about an episode as HTML; equal files give equal text.

    Args:
        results: The files; the page names missing ones.
        name: Id of the episode.
        settings: All settings.
        drives: The user's own runs of the episode.

    Raises:
        ShowError: The episode is unknown or its scene is missing.
    """
    episode = results.episodes[results.choose([name])[0]]
    scene, reasonings = results.scene(episode), collect_reasonings(results, episode, settings)
    static, embodied = list_static(results, episode), list_embodied(results, episode)
    tours = [_show_tour(results, episode, reasonings, visit) for visit in (0, 1)]
    shown = list_shown(settings)
    pointing = _part([list(rows) for _, rows in groupby(static, key=lambda row: row.arm.name)], shown)
    by_agent: dict[str, list[Drive]] = {}
    for drive in drives:
        by_agent.setdefault(drive.run.arm, []).append(drive)
    own = [(agent, [describe_stop(drive.run, episode.relation.past) for drive in runs]) for agent, runs in by_agent.items()]
    stops = [stop for of in (*(row.stops for row in embodied), *(of for _, of in own)) for stop in of]
    is_answered = any(row.outcome is not None for row in static) or any(row.stops for row in embodied)
    known = [item.similarity for one in reasonings for items in one.items for item in items if item.similarity is not None]
    values = {
        "episode": episode,
        "relation": episode.relation,
        "changes": [(change.instance, _describe_change(change)) for change in episode.scripted],
        "others": [(change.instance, _describe_change(change)) for change in episode.others],
        "answer": episode.answer,
        "reasonings": [_list_evidence(reasoning) for reasoning in reasonings],
        "evidence": next((k for k, one in enumerate(reasonings) if one.arm == settings.comparisons.agent), 0),
        "plans": [draw_visit(scene, episode, reasonings, visit) for visit in (0, 1)],
        "beyond": [max((count_beyond(scene, episode, one, visit) for one in reasonings), default=0) for visit in (0, 1)],
        "overlay": draw_overlay(scene, episode, reasonings, static, embodied, by_agent, shown, settings.success.radius_m),
        "static": pointing,
        "several": [any(row.run is not None for rows in part for row in rows) for part in pointing],
        "embodied": _part([[row] for row in embodied], shown),
        "own": own,
        "answered": is_answered,
        "own_task": any(stop.own_task for stop in stops),
        "arms": [*(row.arm.name for row in static), *(row.arm.name for row in embodied)],
        "shown": shown,
        "tours": tours,
        "rows": list(zip_longest(*tours)),
        "absent": _list_absent(results, episode, is_answered, bool(reasonings)),
        "settings": settings,
        "similarities": (min(known), max(known)) if known else None,
        "colours": ["#{:02x}{:02x}{:02x}".format(*colour) for colour in (PALE, DEEP)],
        "command": results.command(episode.split),
    }
    return environment().get_template("page.html").render(values)


def index(results: Results, names: Sequence[str], files: Sequence[Path]) -> str:
    """Return the index of pages as HTML, one row per episode with a mark per arm and seed or run.

    Args:
        results: The files.
        names: Ids of the episodes.
        files: Their pages, relative to the index.
    """
    rows = []
    for name, file in zip(names, files, strict=True):
        episode = results.episodes[name]
        static: dict[str, list[tuple[str, str]]] = {}
        for row in list_static(results, episode):
            words = row.words if row.run is None else f"run {row.run}: {row.words}"
            static.setdefault(row.arm.name, []).append((row.verdict, words))
        embodied = [
            [(stop.verdict, f"seed {stop.seed}: {stop.words}") for stop in row.stops] for row in list_embodied(results, episode)
        ]
        rows.append({"episode": episode, "file": file.as_posix(), "marks": [*static.values(), *embodied]})
    arms = sorted(results.arms, key=lambda arm: arm.kind != "static")
    return environment().get_template("index.html").render(rows=rows, arms=arms)


def list_shown(settings: Settings) -> dict[str, str]:
    """Return the arms that are visible at first, the reference agent and the joint agent: titles by the arms' names."""
    comparisons = settings.comparisons
    agents = {comparisons.agent, *(name for name, entry in comparisons.controls.items() if entry.role == "joint")}
    systems = {title: system for title, system in comparisons.overview.items() if system.static in agents}
    return {arm: title for title, system in systems.items() for arm in (system.static, system.embodied) if arm is not None}


def _part(arms: Sequence[Rows], shown: Mapping[str, str]) -> tuple[list[Rows], list[Rows]]:
    """Split the rows of arms into those that are visible at first and the others."""
    parts: tuple[list[Rows], list[Rows]] = [], []
    for rows in arms:
        parts[rows[0].arm.name not in shown].append(rows)
    return parts


def _show_tour(results: Results, episode: Episode, reasonings: Sequence[Reasoning], visit: int) -> list[Stand]:
    which = VISITS[visit]
    directory = results.visit_directory(episode, which)
    recorded = results.visit(directory)
    if recorded is None:
        return []
    return show_tour(recorded, directory, episode, results.detections(episode, which), reasonings, visit)


def _describe_change(change: Change) -> str:
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


def _list_evidence(reasoning: Reasoning) -> dict[str, Any]:
    """Return the tables about a reasoning: pairs, the cheapest first, and unmatched objects, the farthest first."""

    def list_unmatched(visit: int) -> list[Any]:
        far = {item.id: math.inf if item.nearest_m is None else item.nearest_m for item in reasoning.unmatched(visit)}
        return sorted(reasoning.unmatched(visit), key=lambda item: (-far[item.id], item.id))

    return {
        "arm": reasoning.arm,
        "title": reasoning.title,
        "own_maps": reasoning.own_maps,
        "pairs": sorted(reasoning.pairs, key=lambda pair: (pair.cost_m, pair.first, pair.second)),
        "unmatched": [list_unmatched(visit) for visit in (0, 1)],
        "objects": [len(items) for items in reasoning.items],
        "grounded": [len(reasoning.grounded(visit)) for visit in (0, 1)],
    }


def _list_absent(results: Results, episode: Episode, is_answered: bool, has_evidence: bool) -> list[str]:
    """Return sentences about missing files, each with the command that makes them."""
    make = "“snakemake --cores 2 -- results/{}”".format
    missing = []
    if any(results.visit(results.visit_directory(episode, which)) is None for which in VISITS):
        missing.append(f"No recorded tours here: {make(f'visits/{episode.split}.jsonl')} records them.")
    elif any(results.detections(episode, which) is None for which in VISITS):
        missing.append(f"No detections here: {make(f'detections/{episode.split}')} makes them.")
    if any(results.map(episode, which) is None for which in VISITS):
        missing.append(f"No maps here: {make(f'maps/{episode.split}')} makes them.")
    elif episode.noun not in results.nouns:
        missing.append(f"No embedding of “{episode.noun}” here, so no similarities: {make('nouns.npz')} makes it.")
    if not is_answered:
        missing.append(f"No arm’s answers on the split {episode.split} here: “{results.command(episode.split)}” makes them.")
    elif not has_evidence:
        missing.append(f"No evidence of any arm here: “{results.command(episode.split)}” records it.")
    return missing
