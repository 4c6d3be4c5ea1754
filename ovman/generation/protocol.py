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
from ovman.settings import Lighting, Others, SecondTour, Settings, Split
from ovman.settings.benchmark import PerRelation
from ovman.settings.sensors import Errors

LIGHT_DECIMALS = 3


@dataclass(frozen=True)
class Drawing:
    """How the candidates of a split are drawn in a scene.

    names: of the split in random streams and ids. tours: of the visits of every candidate; light, errors: each candidate draws
    its own of these. draws: candidates per relation. tries: attempts per draw that is not refused; None counts refused candidates
    as drawn. changes, others: as `Split` has them.
    """

    split: str
    names: tuple[str, ...]
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

    @staticmethod
    def of(split: Split, scene: Scene, constants: Settings) -> Drawing:
        """Return how a split draws in a scene. constants: sensors and tour.headings."""
        both = tours(scene, constants.tour.headings, split.second_tour)
        errors = None if split.sensors is None else getattr(constants.sensors, split.sensors)
        return Drawing(split.name, split.stream, both, split.draws, split.tries, split.changes, split.others, split.light, errors)

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


def drawings(scene: Scene, constants: Settings) -> Iterator[Drawing]:
    """Return the splits that have a scene. constants: splits, sensors and tour.headings."""
    for split in constants.splits.values():
        if scene.scene in split.scenes:
            yield Drawing.of(split, scene, constants)
