"""The true instances of recorded tours: what every pixel shows, and where the objects of a scene are.

The room's shell is no instance: the floor is none though the simulator lists it as an object, and walls, ceilings and other
pieces that are no objects have no entry in the scene's record. The detector is taught the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ovman.perception.tour_files import picture
from ovman.records.scene import Scene
from ovman.records.visit import MILLIMETRES, Visit

SHELL = frozenset({"Floor"})


@dataclass(frozen=True, slots=True)
class TrueObject:
    """An object of a scene before anything changes: centre and size (x, y, z) of its axis-aligned box, metres."""

    id: str
    category: str
    centre: tuple[float, float, float]
    size: tuple[float, float, float]


@dataclass(frozen=True)
class TrueScene:
    """The objects of a scene that are instances, by the order of its record."""

    name: str
    objects: tuple[TrueObject, ...]

    @staticmethod
    def of(scene: Scene) -> TrueScene:
        """From the record of the stage "scenes"."""
        return TrueScene(
            scene.scene,
            tuple(
                TrueObject(o.id, o.category, (o.position.x, o.position.y, o.position.z), (o.size.x, o.size.y, o.size.z))
                for o in scene.objects
                if o.category not in SHELL
            ),
        )

    @staticmethod
    def load(path: Path) -> TrueScene:
        """From a file of the stage "scenes". Raises RecordError."""
        return TrueScene.of(Scene.parse(path.read_text(encoding="utf-8"), str(path)))

    @property
    def categories(self) -> tuple[str, ...]:
        """The categories present, each once, sorted."""
        return tuple(sorted({o.category for o in self.objects}))

    def ids(self, index: np.ndarray, instances: Sequence[str]) -> np.ndarray:
        """(H, W) int32 of a view: the pixel's object as an index into `objects`, -1 for none.

        index (H, W): as the visit's ids image has it, 0 for nothing and k for the k-th of `instances`.
        """
        place = {o.id: i for i, o in enumerate(self.objects)}
        table = np.array([-1, *(place.get(name, -1) for name in instances)], np.int32)
        made: np.ndarray = table[index]
        return made


def true_ids(scene: TrueScene, visit: Visit, directory: Path, view: int) -> np.ndarray:
    """(H, W) int32 of a view of a recorded visit, as `TrueScene.ids`. TourError names an image that is missing or damaged."""
    return scene.ids(picture(directory / f"{view:02d}_ids.png"), visit.views[view].instances)


def depth_m(directory: Path, view: int) -> np.ndarray:
    """(H, W) of a view of a recorded visit, metres along the optical axis. TourError as `true_ids`."""
    return picture(directory / f"{view:02d}_depth.png") / MILLIMETRES
