"""What the agents of a job observe in one scene: recorded tours, maps that were made of them, nouns, networks.

Everything is read or loaded at its first use: a job whose answers are all known opens no file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from ovman.agents.interface import Visit
from ovman.evaluation.perceived import Perceived
from ovman.perception.clusters import Cluster
from ovman.perception.detected import Detected
from ovman.perception.records import read_detections, read_maps, read_nouns
from ovman.settings import Arm, Need, Settings

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")
FILES: Mapping[Need, str] = {
    need: str(need) for need in (Need.MAPS, Need.MAINTAINED, Need.DUALMAP, Need.DETECTIONS, Need.SEGMENTS)
}
"""By need: the workflow's name of the file that was made of a scene."""


class MapsByContent:
    """Maps that were made of recorded tours, looked up by the content of the tour. No frame is read.

    maps: clusters by ``Visit.content``. Names of visits reveal the change, so an agent does not learn them.
    """

    def __init__(self, maps: Mapping[str, Sequence[Cluster]]) -> None:
        self._maps = dict(maps)

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of the visit's map. ValueError for a tour of which no map was made."""
        if visit.content is None or visit.content not in self._maps:
            raise ValueError(f"no map was made of the tour with the content {visit.content}; make the stage maps again")
        return self._maps[visit.content]


class ObservationStore:
    """What an arm's agents are given in a scene.

    arm: whose agents; what its entry does not need is refused in one line. settings: section perception, for an arm that needs
    networks. field_of_view_deg: of the tours' camera, vertical. visits: directory of the scene's recorded visits. files: what was
    made of the scene, by the names that the workflow has for it ("maps", "nouns", "maintained", "dualmap",
    "detections", "segments"). elsewhere: directories of recorded visits that do not lie in `visits`, by their names.
    """

    def __init__(
        self,
        arm: Arm,
        settings: Settings,
        field_of_view_deg: float,
        visits: Path,
        files: Mapping[str, Path] = {},
        elsewhere: Mapping[str, Path] = {},
    ) -> None:
        self._arm, self._settings, self._field_of_view_deg = arm, settings, field_of_view_deg
        self._visits, self._files, self._elsewhere = visits, files, elsewhere
        self._made: dict[Hashable, object] = {}
        self._phrases: dict[str, np.ndarray] = {}

    @cached_property
    def perceived(self) -> Perceived:
        """The maps of the scene's visits, and the nouns."""
        return Perceived(self.made(Need.MAPS, read_maps), self._nouns)

    @cached_property
    def mapper(self) -> MapsByContent:
        """The scene's maps by what the tours show."""
        maps = self.perceived.maps
        return MapsByContent({self._content(name): clusters for name, clusters in maps.items()})

    @property
    def detected(self) -> Mapping[str, Detected]:
        """The detections of the scene's visits by their names."""
        return self.made(Need.DETECTIONS, read_detections)

    def detections_in(self, visit: Visit) -> Detected:
        """The detections of a recorded visit, found by what it shows. ValueError for a tour that nothing was detected in."""
        if visit.content not in self._detected_by_content:
            raise ValueError(f"no tour with the content {visit.content} was looked at; make the stage detections again")
        return self._detected_by_content[visit.content]

    def noun(self, phrase: str) -> np.ndarray:
        """Unit embedding (K,) of a noun phrase, by the encoder that made the features of the maps.

        ValueError for a phrase that was not embedded and cannot be, as the arm needs no networks.
        """
        if "nouns" in self._files and (phrase in self._nouns or not self._needs(Need.NETWORKS)):
            return Perceived({}, self._nouns).noun(phrase)
        if phrase not in self._phrases:
            _, encoder = self.networks
            self._phrases[phrase] = encoder.texts([phrase])[0]
        return self._phrases[phrase]

    @cached_property
    def networks(self) -> tuple[Detector, Encoder]:
        """The detector and the encoder of section perception, loaded once. ValueError for an arm that does not need them."""
        self._allow(Need.NETWORKS)
        from ovman.perception.networks import detector_of, encoder_of

        return detector_of(self._settings.perception), encoder_of(self._settings.perception)

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """What was made of the scene, read once. ValueError for what the arm does not need or nothing has made."""
        self._allow(need)
        if FILES[need] not in self._files:
            raise ValueError(f"arms.{self._arm.name} needs {need}, and {self._visits.name} has none; make them")
        if (need, read) not in self._made:
            self._made[need, read] = read(self._files[FILES[need]])
        return cast(Made, self._made[need, read])

    def visit(self, name: str, reachable: np.ndarray) -> Visit:
        """The recorded visit of that name, with the positions (K, 2) that can be reached in it; without frames for an arm that
        needs neither tours, maps, detections nor segments.
        """
        if any(self._needs(need) for need in (Need.TOURS, Need.MAPS, Need.DETECTIONS, Need.SEGMENTS)):
            from ovman.evaluation.recorded_tour import recorded

            return recorded(self._recording(name), self._field_of_view_deg, reachable)
        return Visit((), reachable)

    def cache_key(self, visits: Sequence[str], phrase: str) -> dict[str, Any]:
        """Cache key: everything of the observations of these visits that the arm's answer can depend on, JSON-serialisable."""
        found: dict[str, Any] = {}
        if self._needs(Need.TOURS):
            found["tours"] = [self._content(name) for name in visits]
        if self._needs(Need.MAPS):
            found["maps"] = [[_numbers(cluster) for cluster in self.perceived.maps[name]] for name in visits]
        if self._needs(Need.DETECTIONS):
            found["detections"] = [self.detected[name].content for name in visits]
        if any(self._needs(need) for need in (Need.MAPS, Need.DETECTIONS, Need.SEGMENTS)):
            found["noun"] = self.noun(phrase).tolist()
        for need in (Need.MAINTAINED, Need.DUALMAP, Need.SEGMENTS):
            if self._needs(need):
                found[need] = self.made(need, _digest)
        if self._needs(Need.NETWORKS):
            found["networks"] = self._looked_at_by
        return found

    @cached_property
    def _detected_by_content(self) -> Mapping[str | None, Detected]:
        return {self._content(name): seen for name, seen in self.detected.items()}

    @cached_property
    def _looked_at_by(self) -> object:
        from ovman.perception.networks import looked_at_by

        return looked_at_by(self._settings.perception)

    @cached_property
    def _nouns(self) -> Mapping[str, np.ndarray]:
        return read_nouns(self._files["nouns"])

    def _content(self, name: str) -> str:
        from ovman.evaluation.recorded_tour import content

        return content(self._recording(name), self._field_of_view_deg)

    def _recording(self, name: str) -> Path:
        return self._elsewhere.get(name, self._visits / name)

    def _needs(self, need: Need) -> bool:
        return need in self._arm.needs

    def _allow(self, need: Need) -> None:
        if not self._needs(need):
            raise ValueError(f"arms.{self._arm.name} is given no {need}; write needs: [{need}] in its entry")


def of_scene(scene: str, files: Mapping[str, Sequence[Path]]) -> dict[str, Path]:
    """Of files by the workflow's names for them, those of a scene: the one named after it, or the one of all scenes (nouns)."""
    found = {name: [path for path in paths if path.stem == scene or name == "nouns"] for name, paths in files.items()}
    return {name: paths[0] for name, paths in found.items() if paths}


def _numbers(cluster: Cluster) -> list[Any]:
    return [np.asarray(part).tolist() for part in (cluster.position, cluster.feature, cluster.track, cluster.views)]


def _digest(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
