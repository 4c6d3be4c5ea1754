"""Write the page about an episode, one self-contained HTML file."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import pairwise, zip_longest
from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined

from ovman.agents.interface import VISITS
from ovman.perception.records import Detected
from ovman.records.episode import Episode
from ovman.records.geometry import Point, Position
from ovman.records.scene import Change
from ovman.report.show.answers import Entry, list_entries
from ovman.report.show.evidence import Evidence
from ovman.report.show.plan import Frame, label_answers, label_objects, list_furniture, radius
from ovman.report.show.results import Results
from ovman.report.show.tours import show_tour
from ovman.settings import Kind

TEMPLATES = Environment(
    loader=PackageLoader("ovman.report.show", "templates"),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def render_page(
    results: Results,
    episode: Episode,
    evidence: Evidence | None = None,
    tours: Mapping[str, tuple[Path, Detected]] | None = None,
    own: Sequence[Entry] = (),
    note: str = "",
) -> str:
    """Return the page about an episode as HTML; equal files give equal text. ShowError if the scene is missing.

    evidence: Of the reference agent. tours: Folder and detections of the recorded tour of each visit. own: The user's own runs of
    the episode. note: A sentence about the episode.
    """
    scene, settings = results.scene(episode), results.settings
    frame = Frame.of(scene, episode)
    pointing, navigating = (list_entries(results, episode, kind) for kind in (Kind.STATIC, Kind.EMBODIED))
    items = [evidence.items[which] if evidence else [] for which in VISITS]
    shots = [show_tour(*tours[which], episode, of) for which, of in zip(VISITS, items, strict=True)] if tours else []
    return TEMPLATES.get_template("page.html").render(
        episode=episode,
        note=note,
        scripted=[(change.instance, describe_change(change)) for change in episode.scripted],
        others=[(change.instance, describe_change(change)) for change in episode.others],
        scene=scene,
        frame=frame,
        furniture=[list(list_furniture(scene, [episode], visit)) for visit in (0, 1)],
        visits=VISITS,
        items=items,
        names=[label_objects(frame, of) for of in items],
        radius=radius,
        matched=evidence.matched if evidence else "",
        tables={"Your runs": list(own), "Arms that navigate": navigating, "Arms that point": pointing},
        labels=label_answers(frame, episode, [*own, *navigating, *pointing]),
        shots=list(zip_longest(*shots)),
        settings=settings,
    )


def describe_change(change: Change) -> str:
    """Return a change in words."""

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
