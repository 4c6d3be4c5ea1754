"""The page about one episode: the query, the answers of the arms, and the truth. One self-contained HTML file."""

from __future__ import annotations

import math
from collections.abc import Sequence
from itertools import groupby, pairwise, zip_longest
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from ovman.agents.interface import VISITS
from ovman.models.change import Change
from ovman.models.episode import Episode
from ovman.models.geometry import Point, Position
from ovman.models.settings import Settings
from ovman.report.show.filmstrip import Stand, stands
from ovman.report.show.plan import DEEP, PALE, beyond, overlay_plan, visit_plan
from ovman.report.show.reasoning import Reasoning, reasonings
from ovman.report.show.results import MAKE, Results
from ovman.report.show.room import Room
from ovman.report.show.verdicts import embodied_rows, static_rows


def environment() -> Environment:
    """The environment of the templates beside this module; all values are escaped except drawings of this package."""
    return Environment(
        loader=PackageLoader("ovman.report.show", "templates"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )


def page(results: Results, episode_id: str, settings: Settings) -> str:
    """The page about an episode as HTML; equal files give equal text.

    Raises ShowError for an unknown episode or a missing scene. The page names other missing files.
    """
    (name,) = results.chosen([episode_id])
    episode = results.episodes[name]
    room = Room(results.scene(episode.scene), episode)
    found = reasonings(results, episode, settings)
    static, embodied = static_rows(results, episode), embodied_rows(results, episode)
    tours = [_tour(results, episode, found, visit) for visit in (0, 1)]
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
            plans=[visit_plan(room, found, visit) for visit in (0, 1)],
            beyond=[max((beyond(room, reasoning, visit) for reasoning in found), default=0) for visit in (0, 1)],
            overlay=overlay_plan(room, found, static, embodied, settings.success.radius_m),
            static=[list(rows) for _, rows in groupby(static, key=lambda row: row.arm.name)],
            several=any(row.run is not None for row in static),
            embodied=embodied,
            own_task=any(stop.own_task for row in embodied for stop in row.stops),
            tours=tours,
            rows=_rows(tours),
            absent=_absent(results, episode, found),
            settings=settings,
            similarities=_similarities(found),
            colours=["#{:02x}{:02x}{:02x}".format(*colour) for colour in (PALE, DEEP)],
            make=MAKE,
        )
    )


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


def _absent(results: Results, episode: Episode, found: Sequence[Reasoning]) -> list[str]:
    """Sentences about missing files, each with the command that makes them."""
    missing = []
    if any(results.visit(results.visit_directory(episode, which)) is None for which in VISITS):
        missing.append(f"No recorded tours here: “{MAKE}” records them.")
    elif any(results.detected(episode, which) is None for which in VISITS):
        missing.append(f"No detections here: “{MAKE}” makes them.")
    if any(results.map(episode, which) is None for which in VISITS):
        missing.append(f"No maps here: “{MAKE}” makes them.")
    elif episode.noun not in results.nouns:
        missing.append(f"No embedding of “{episode.noun}” here, so no similarities: “{MAKE}” makes it.")
    if not found:
        missing.append(f"No evidence of any arm here: “{MAKE}” records it.")
    return missing
