"""What candidates are drawn of a scene for a split: its tours, how many, and what changes beside the scripted change. Pure."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from ovman import seeds
from ovman.records.geometry import Point
from ovman.records.scene import Scene
from ovman.records.sensors import Light, Sensors
from ovman.records.sighting import VisitPair
from ovman.records.tour import Tour
from ovman.settings import MAIN, Lighting, Others, SecondTour, Settings
from ovman.settings.benchmark import PerRelation
from ovman.settings.sensors import Errors

LIGHT_DECIMALS = 3


@dataclass(frozen=True)
class Drawing:
    """How the candidates of a split are drawn in a scene.

    tours: of the visits, as all candidates have them; light, errors: what a candidate's have besides. draws: candidates by
    relation. tries: how many instances are tried at most for each candidate that is not refused; None where a candidate
    counts that is refused, too. changes, others: as `Split` has them.
    """

    split: str
    tours: VisitPair[Tour]
    draws: PerRelation
    tries: int | None = None
    changes: tuple[int, ...] = (1,)
    others: Others | None = None
    light: Lighting | None = None
    errors: Errors | None = None

    def of_candidate(self, name: str, seed: int) -> VisitPair[Tour]:
        """The tours of a candidate: with a light of its own in the second visit, and sensors that err in another way in each.

        seed: root of every random number.
        """
        light = None
        if self.light is not None:
            rng = seeds.generator(seed, "light", name)
            drawn = {key: round(float(rng.uniform(low, high)), LIGHT_DECIMALS) for key, (low, high) in self.light.ranges.items()}
            light = Light(**drawn, materials=seeds.integer(seed, "materials", name) if self.light.materials else None)

        def sensors(which: str) -> Sensors | None:
            return None if self.errors is None else Sensors(errors=self.errors, seed=seeds.integer(seed, "sensors", name, which))

        first, second = self.tours.first, self.tours.second
        return VisitPair[Tour](
            first=first.model_copy(update={"sensors": sensors("first")}),
            second=second.model_copy(update={"sensors": sensors("second"), "light": light}),
        )

    @property
    def names(self) -> tuple[str, ...]:
        """What the random numbers of the split are called after; the benchmark's own have no name of a split."""
        return () if self.split == MAIN else (self.split,)

    def id(self, scene: str, relation: str, number: int) -> str:
        """The id of a candidate."""
        return "/".join((scene, relation, "-".join((*self.names, f"{number:04d}"))))


def tours(scene: Scene, headings: int, second: SecondTour | None) -> VisitPair[Tour]:
    """The tours of both visits: the same twice, or a second one of its own."""
    first = Tour(waypoints=scene.waypoints, headings=headings)
    if second is None:
        return VisitPair[Tour](first=first, second=first)
    waypoints = scene.other_waypoints if second.other_waypoints else scene.waypoints
    return VisitPair[Tour](first=first, second=Tour(waypoints=waypoints, headings=headings, first_yaw_deg=second.first_yaw_deg))


def keeps_free(scene: Scene, both: VisitPair[Tour]) -> tuple[Point, ...]:
    """Where nothing is put, as the agent stands there: the waypoints of the second tour, and where the simulator begins, which is
    beside the first waypoint of the scene's own tour."""
    again = both.second.waypoints == scene.waypoints
    return both.second.waypoints if again else (*both.second.waypoints, scene.start)


def main_drawing(scene: Scene, constants: Settings) -> Drawing:
    """The benchmark's own split in a scene. constants: candidates.draws and tour.headings."""
    return Drawing(MAIN, tours(scene, constants.tour.headings, None), constants.candidates.draws)


def drawings(scene: Scene, constants: Settings) -> Iterator[Drawing]:
    """The splits that have the scene, the benchmark's own first. constants: candidates.draws, splits and tour.headings.

    The benchmark's scenes are those that no split keeps for itself, so that nothing is drawn anew where another scene is added.
    """
    kept = any(not split.main_job and scene.scene in (split.scenes or ()) for split in constants.splits.values())
    if not kept:
        yield main_drawing(scene, constants)
    for name, split in constants.splits.items():
        if not kept if split.scenes is None else scene.scene in split.scenes:
            both = tours(scene, constants.tour.headings, split.second_tour)
            errors = None if split.sensors is None else getattr(constants.sensors, split.sensors)
            yield Drawing(name, both, split.draws, split.tries, split.changes, split.others, split.light, errors)
