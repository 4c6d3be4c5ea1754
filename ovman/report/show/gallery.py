"""Write the gallery of a split: one self-contained HTML file with a card per world pair and filters over its queries."""

from __future__ import annotations

import math
import shlex
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from pathlib import Path
from urllib.parse import quote

from ovman.analysis.outcomes import EXPECTED
from ovman.records.episode import Episode
from ovman.records.geometry import Point, floor_point
from ovman.records.run import Score
from ovman.records.scene import Change, Scene
from ovman.records.task import Relation
from ovman.report.show.answers import describe_arm, shown_titles
from ovman.report.show.page import TEMPLATES, describe_change
from ovman.report.show.plan import Frame, Label, Labels, list_furniture
from ovman.report.show.results import Results
from ovman.settings import Kind

SIZE, MARGIN_M = (340.0, 320.0), 0.3
"""Largest size of a plan, and the margin around the home."""
KINDS = {"displace": "moved", "enable": "added", "disable": "removed", "motion": "moving"}
"""Classes of changes by kind."""
FLOOR_PLANS = {0: "kitchen", 2: "living room", 3: "bedroom", 4: "bathroom"}
"""Kinds of AI2-THOR's rooms by the hundreds of their numbers."""
NAVIGATING, POINTING, CONTROLS, OWN = "Agents that navigate", "Agents that point", "Controls", "Your runs"


@dataclass(frozen=True, slots=True)
class Agent:
    """An arm, or a user's own agent. is_shown: whether its verdict stands next to the query."""

    key: str
    title: str
    group: str
    is_shown: bool


@dataclass(frozen=True, slots=True)
class Verdict:
    """The success of an agent on a query.

    Attributes:
        share: Of its runs, those that succeed; for a stochastic pick the probability.
        runs: Their number.
        is_pick: Whether it is a stochastic pick.
    """

    share: float
    runs: int
    is_pick: bool = False

    @property
    def is_found(self) -> bool:
        """Whether every run finds the answer."""
        return self.share == 1.0

    @property
    def note(self) -> str:
        """The share in words where the agent neither always succeeds nor always fails."""
        if self.share in (0.0, 1.0):
            return ""
        return f" (by chance, {self.share:.2f})" if self.is_pick else f" ({round(self.share * self.runs)} of {self.runs} runs)"


Verdicts = Mapping[str, Mapping[str, Verdict]]
"""By agent and episode."""


def render_gallery(results: Results, split: str, pages: Path, own: Mapping[str, Sequence[Score]] = {}) -> str:
    """Return the gallery of a split as HTML; equal files give equal text. ShowError if episodes or a scene are missing.

    pages: The folder of the gallery, where pages of episodes are linked if they are there. own: The user's own runs by title.
    """
    episodes = results.of_split(split)
    verdicts = read_verdicts(results, split, own)
    agents = list_agents(results, verdicts, own)
    pairs: dict[str, list[Episode]] = {}
    for episode in episodes:
        pairs.setdefault(episode.streams, []).append(episode)
    rooms, cards = Counter[str](), []
    of_scene, numbers = Counter(queries[0].scene for queries in pairs.values()), Counter[str]()
    for name, queries in pairs.items():
        scene = results.scene(queries[0])
        rooms[name_rooms(scene)] += len(queries)
        numbers[scene.scene] += 1
        title = scene.scene if of_scene[scene.scene] == 1 else f"{scene.scene}, pair {numbers[scene.scene]}"
        cards.append(_render_card(name, title, scene, queries, agents, verdicts, pages))
    found = {agent.key: sum(verdict.is_found for verdict in verdicts[agent.key].values()) for agent in agents}
    failed = {agent.key: len(verdicts[agent.key]) - found[agent.key] for agent in agents}
    groups = [(name, list(group)) for name, group in groupby(agents, key=lambda agent: agent.group)]
    relations, nouns = (Counter(getattr(one, key) for one in episodes) for key in ("relation", "noun"))
    return TEMPLATES.get_template("gallery.html").render(
        split=split,
        cards=cards,
        queries=len(episodes),
        agents=agents,
        groups=groups,
        choices={
            "relation": [(name.value, relations[name]) for name in Relation if name in relations],
            "rooms": sorted(rooms.items()),
            "noun": sorted(nouns.items()),
        },
        verdicts={"found": found, "failed": failed},
    )


def read_verdicts(results: Results, split: str, own: Mapping[str, Sequence[Score]] = {}) -> Verdicts:
    """Return the verdicts of the metrics on a split, and those of the user's own runs."""
    judged: dict[str, dict[str, list[tuple[float, bool]]]] = {}
    for title, runs in own.items():
        for run in runs:
            judged.setdefault(title, {}).setdefault(run.episode, []).append((float(run.success), False))
    for kind in (Kind.EMBODIED, Kind.STATIC):
        for row in results.outcomes(split, kind):
            judged.setdefault(row.arm, {}).setdefault(row.episode, []).append((row.success, row.outcome == EXPECTED))
    return {
        arm: {
            episode: Verdict(math.fsum(share for share, _ in runs) / len(runs), len(runs), any(pick for _, pick in runs))
            for episode, runs in of_arm.items()
        }
        for arm, of_arm in judged.items()
    }


def list_agents(results: Results, verdicts: Verdicts, own: Mapping[str, Sequence[Score]] = {}) -> list[Agent]:
    """Return the agents that have verdicts, the user's first, then those that navigate, that point, and controls."""
    arms = [arm for arm in results.settings.arms.values() if arm.name in verdicts and arm.name not in own]
    systems = Counter((arm.kind, arm.system) for arm in arms)
    shown, agents = shown_titles(results), [Agent(title, title, OWN, True) for title in own]
    for arm in arms:
        is_alone = systems[arm.kind, arm.system] == 1
        title = shown.get(arm.name) or (arm.system if is_alone else f"{arm.system}, {describe_arm(arm)}")
        group = CONTROLS if arm.control else NAVIGATING if arm.kind is Kind.EMBODIED else POINTING
        navigates = ", navigating" * (arm.kind is Kind.EMBODIED)
        agents.append(Agent(arm.name, title + navigates, group, arm.name in shown))
    return sorted(agents, key=lambda agent: (OWN, NAVIGATING, POINTING, CONTROLS).index(agent.group))


def name_rooms(scene: Scene) -> str:
    """Return the number of a home's rooms in words, or the kind of room that a floor plan is."""
    if scene.rooms is not None:
        return f"{len(scene.rooms)} room{'s' * (len(scene.rooms) > 1)}"
    number = scene.scene.removeprefix("FloorPlan").partition("_")[0]
    return FLOOR_PLANS.get(int(number) // 100, "other room") if number.isdigit() else "other room"


def _render_card(
    name: str, title: str, scene: Scene, episodes: Sequence[Episode], agents: Sequence[Agent], verdicts: Verdicts, pages: Path
) -> str:
    floor = [corner for corners in scene.rooms or () for corner in corners] or scene.reachable
    changes, frame = episodes[0].changes, Frame.around(floor, SIZE, MARGIN_M)
    queries = []
    for number, episode in enumerate(episodes, start=1):
        judged = [(agent, verdicts[agent.key].get(episode.id)) for agent in agents]
        queries.append(
            {
                "number": number,
                "episode": episode,
                "found": "".join("-" if verdict is None else "1" if verdict.is_found else "0" for _, verdict in judged),
                "judged": [(agent, verdict) for agent, verdict in judged if verdict is not None],
                "page": f"{quote(episode.id)}.html" if (pages / f"{episode.id}.html").is_file() else "",
            }
        )
    has_pages = any(query["page"] for query in queries)
    command = f"ovman show {shlex.quote(f'{scene.scene}/*')} --output {shlex.quote(str(pages))}"
    rendered = TEMPLATES.get_template("card.html").render(
        name=name,
        title=title,
        scene=scene,
        rooms=name_rooms(scene),
        frame=frame,
        furniture=[list(list_furniture(scene, episodes, visit)) for visit in (0, 1)],
        marks=[list(_mark_changes(scene, changes, visit)) for visit in (0, 1)],
        labels=[_label_queries(frame, episodes, changes, visit) for visit in (0, 1)],
        changes=[(KINDS[change.kind], change, describe_change(change)) for change in changes],
        queries=queries,
        command="" if has_pages else command,
    )
    return rendered


def _mark_changes(scene: Scene, changes: Sequence[Change], visit: int) -> list[tuple[str, Point, Point, str]]:
    """Return class, centre, size and id of the changed instances that a visit shows."""
    things, marks = {thing.id: thing for thing in scene.objects}, []
    for change in changes:
        at = floor_point((change.before, change.after)[visit])
        if at is not None and change.instance in things:
            size = things[change.instance].turned(change.yaw_deg if visit else None).size
            marks.append((KINDS[change.kind], at, (size.x, size.z), change.instance))
    return marks


def _label_queries(frame: Frame, episodes: Sequence[Episode], changes: Sequence[Change], visit: int) -> list[Label]:
    """Return the numbers of the queries that a visit answers, next to their answers."""
    labels, found = Labels(frame), []
    for change in changes:
        if (at := floor_point((change.before, change.after)[visit])) is not None:
            labels.keep(frame.at(at), 8.0)
    for number, episode in enumerate(episodes, start=1):
        if episode.relation.past == (visit == 0):
            found.append(Label(str(number), labels.place(frame.at(episode.answer), 8.0, str(number)), episode.answer))
    return found
