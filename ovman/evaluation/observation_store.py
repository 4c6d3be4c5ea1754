"""What the agents of a job see with in one scene: recorded tours, maps that were made of them, nouns, networks.

Everything is read or loaded when it is first asked for: a job whose answers are all known opens nothing.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import Visit
from ovman.evaluation.perceived import Perceived
from ovman.models.settings import Arm, Need, Settings
from ovman.perception.records import read_maps, read_nouns

if TYPE_CHECKING:
    from ovman.agents.reference.mapper import KeptMaps
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")
FILES: Mapping[Need, str] = {Need.MAPS: "maps", Need.DUALMAP: "dualmap"}
"""By need: how the workflow calls the file that was made of a scene."""


class Senses:
    """What an arm's agents are given in a scene.

    arm: whose; what its entry does not need is refused in one line. constants: the stage's view, with camera.field_of_view_deg
    and, for networks, the section perception. visits: directory of the scene's recorded visits. files: what was made of the
    scene, by the names that the workflow has for it ("maps", "nouns", "dualmap").
    """

    def __init__(self, arm: Arm, constants: Settings, visits: Path, files: Mapping[str, Path]) -> None:
        self._arm, self._constants, self._visits, self._files = arm, constants, visits, files
        self._made: dict[Any, Any] = {}
        self._phrases: dict[str, np.ndarray] = {}

    @cached_property
    def perceived(self) -> Perceived:
        """The maps of the scene's visits, and the nouns."""
        return Perceived(self.made(Need.MAPS, read_maps), self._nouns)

    @cached_property
    def mapper(self) -> KeptMaps:
        """Maps by what the tours show: names of visits tell what was changed, so an agent does not learn them."""
        from ovman.agents.reference.mapper import KeptMaps

        maps = self.perceived.maps
        return KeptMaps({self._content(name): clusters for name, clusters in maps.items()})

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase, by the encoder that made the features of the maps.

        ValueError for a phrase that was not embedded and cannot be, as the arm needs no networks.
        """
        if "nouns" in self._files and (phrase in self._nouns or not self._needs(Need.NETWORKS)):
            return Perceived({}, self._nouns).noun(phrase)
        if phrase not in self._phrases:
            _, encoder = self.sight
            self._phrases[phrase] = encoder.texts([phrase])[0]
        return self._phrases[phrase]

    @cached_property
    def sight(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception, loaded once. ValueError for an arm that does not need them."""
        self._allow(Need.NETWORKS)
        from ovman.perception.networks import detector_of, encoder_of

        return detector_of(self._constants.perception), encoder_of(self._constants.perception)

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """What was made of the scene, read once. ValueError for what the arm does not need."""
        self._allow(need)
        if FILES[need] not in self._files:
            raise ValueError(f"arms.{self._arm.name} needs {need}, and there are none of {self._visits.name}; make them")
        if (need, read) not in self._made:
            self._made[need, read] = read(self._files[FILES[need]])
        return self._made[need, read]

    def visit(self, name: str, reachable: np.ndarray) -> Visit:
        """The recorded visit of that name, with the positions (K, 2) that can be reached in it; without frames for an arm that
        needs neither tours nor maps.
        """
        if self._needs(Need.TOURS) or self._needs(Need.MAPS):
            from ovman.evaluation.recorded_tour import recorded

            return recorded(self._visits / name, self._constants.camera.field_of_view_deg, reachable)
        return Visit((), reachable)

    def seen(self, visits: Sequence[str], phrase: str) -> Any:
        """All that the arm's answer may hang on in these visits, JSON-serialisable: by it a run is found again in a journal."""
        found: dict[str, Any] = {}
        if self._needs(Need.TOURS):
            found["tours"] = [self._content(name) for name in visits]
        if self._needs(Need.MAPS):
            found["maps"] = [[_numbers(cluster) for cluster in self.perceived.maps[name]] for name in visits]
            found["noun"] = self.noun(phrase).tolist()
        if self._needs(Need.DUALMAP):
            found["dualmap"] = self.made(Need.DUALMAP, _digest)
        if self._needs(Need.NETWORKS):
            found["networks"] = self._looked_at_by
        return found

    @cached_property
    def _looked_at_by(self) -> Any:
        from ovman.perception.networks import looked_at_by

        return looked_at_by(self._constants.perception)

    @cached_property
    def _nouns(self) -> Mapping[str, np.ndarray]:
        return read_nouns(self._files["nouns"])

    def _content(self, name: str) -> str:
        from ovman.evaluation.recorded_tour import content

        return content(self._visits / name, self._constants.camera.field_of_view_deg)

    def _needs(self, need: Need) -> bool:
        return need in self._arm.needs

    def _allow(self, need: Need) -> None:
        if not self._needs(need):
            raise ValueError(f"arms.{self._arm.name} is given no {need}; write needs: [{need}] in its entry")


def of_scene(scene: str, files: Mapping[str, Sequence[Path]]) -> dict[str, Path]:
    """Of files by the workflow's names for them, those of a scene: the one that is called after it, or the one that there is."""
    found = {name: [path for path in paths if path.stem == scene or name == "nouns"] for name, paths in files.items()}
    return {name: paths[0] for name, paths in found.items() if paths}


def _numbers(cluster: Any) -> list[Any]:
    return [np.asarray(part).tolist() for part in (cluster.position, cluster.feature, cluster.track, cluster.views)]


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
