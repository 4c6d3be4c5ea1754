"""Observations of a scene as the evaluator hands them to an arm's agents: recorded tours, and what perception made of them.

Everything is read or loaded at its first use: a job whose answers are all known opens no file.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar, cast

import numpy as np

from ovman.agents.interface import Visit
from ovman.perception.clusters import Cluster, ObjectMap
from ovman.perception.records import Detected, read_detections, read_maps, read_nouns
from ovman.records.visit import tour_path
from ovman.settings import Arm, Need, Settings

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Artifact = TypeVar("Artifact")
VISITS = Path("results", "visits")
"""Directory of the recorded visits of all scenes."""
NOUNS = "nouns"
"""The workflow's name of the file with the embeddings of all nouns."""


@dataclass(frozen=True, slots=True, eq=False)
class Perceived:
    """The maps of a scene's visits, and the embeddings of nouns.

    maps: the clusters of every visit by the visit's name; nouns: noun phrases as unit vectors (K,).
    """

    maps: Mapping[str, Sequence[Cluster]]
    nouns: Mapping[str, np.ndarray]

    def map(self, visit: str) -> ObjectMap:
        """Return the map of a visit. ValueError for a visit without a map."""
        if visit not in self.maps:
            raise ValueError(f"the visit {visit!r} has no map; make the stage maps again")
        return ObjectMap.of(self.maps[visit])

    def noun(self, phrase: str) -> np.ndarray:
        """Return the embedding (K,) of a noun phrase. ValueError for one without an embedding."""
        if phrase not in self.nouns:
            raise ValueError(f"the noun {phrase!r} has no embedding; make the stage nouns again")
        return self.nouns[phrase]


def read_perceived(maps_files: Sequence[Path], nouns_file: Path | None) -> dict[str, Perceived]:
    """Return the maps and nouns by scene; nothing without a file of nouns."""
    if nouns_file is None:
        return {}
    nouns = read_nouns(nouns_file)
    return {file.stem: Perceived(read_maps(file), nouns) for file in maps_files}


class ObservationStore:
    """The observations of one scene that an arm's agents are given. What the arm does not need is refused in one line."""

    def __init__(
        self,
        arm: Arm,
        settings: Settings,
        field_of_view_deg: float,
        visits: Path,
        files: Mapping[str, Path] = {},
        elsewhere: Mapping[str, Path] = {},
    ) -> None:
        """Prepare the store; nothing is read yet.

        Args:
            arm: Whose agents are given the observations.
            settings: Section perception, for an arm that needs networks.
            field_of_view_deg: Of the tours' camera, vertical.
            visits: Directory of the scene's recorded visits.
            files: Files of the scene by need, and the file of nouns ("nouns").
            elsewhere: Directories of recorded visits that do not lie in `visits`, by their names.
        """
        self._arm, self._settings, self._field_of_view_deg = arm, settings, field_of_view_deg
        self._visits, self._files, self._elsewhere = visits, files, elsewhere
        self._artifacts: dict[Hashable, object] = {}
        self._phrases: dict[str, np.ndarray] = {}

    @cached_property
    def perceived(self) -> Perceived:
        """The maps of the scene's visits, and the nouns."""
        return Perceived(self.load_artifact(Need.MAPS, read_maps), self._nouns)

    def mapper(self, visit: Visit) -> Sequence[Cluster]:
        """Return the clusters of a recorded visit's map. ValueError for a tour of which no map was made."""
        if visit.content not in self._maps_by_content:
            raise ValueError(f"no map was made of the tour with the content {visit.content}; make the stage maps again")
        return self._maps_by_content[visit.content]

    @property
    def detected(self) -> Mapping[str, Detected]:
        """The detections of the scene's visits by their names."""
        return self.load_artifact(Need.DETECTIONS, read_detections)

    def detections_in(self, visit: Visit) -> Detected:
        """Return the detections of a recorded visit. ValueError for a tour in which nothing was detected."""
        if visit.content not in self._detected_by_content:
            raise ValueError(f"no tour with the content {visit.content} was looked at; make the stage detections again")
        return self._detected_by_content[visit.content]

    def noun(self, phrase: str) -> np.ndarray:
        """Return the unit embedding (K,) of a noun phrase, by the encoder that made the features of the maps.

        ValueError for a phrase that was not embedded and cannot be: the arm neither needs networks nor is in the words track.
        """
        if NOUNS in self._files and (phrase in self._nouns or not self._arm.embeds_phrases):
            return Perceived({}, self._nouns).noun(phrase)
        if phrase not in self._phrases:
            if not self._arm.embeds_phrases:
                self._check_need(Need.NETWORKS)
            self._phrases[phrase] = self._networks[1].texts([phrase])[0]
        return self._phrases[phrase]

    def networks(self) -> tuple[Detector, Encoder]:
        """Return the detector and the encoder of section perception. ValueError for an arm that does not need them."""
        self._check_need(Need.NETWORKS)
        return self._networks

    def true_detections(self, name: str) -> Detected:
        """Return what a detector without errors finds in a recorded visit, embedded by the encoder. Raises as `networks`."""
        if (name, "true") not in self._artifacts:
            from ovman.perception.detections import detect_views
            from ovman.perception.labels import TrueMasks
            from ovman.perception.tour_files import tour

            (_, encoder), file, perception = self.networks(), self._recording(name), self._settings.perception
            sizes = perception.detector.min_mask_px, perception.encoder.crop_padding
            views = list(tour(file, self._field_of_view_deg))
            found = detect_views(views, TrueMasks(file), encoder, *sizes, content=f"true masks of {self._content(name)}")
            self._artifacts[name, "true"] = found
        return cast(Detected, self._artifacts[name, "true"])

    def load_artifact(self, need: Need, read: Callable[[Path], Artifact]) -> Artifact:
        """Read a file of the scene once. ValueError for a file that the arm does not need or that is not there."""
        self._check_need(need)
        if need not in self._files:
            raise ValueError(f"arms.{self._arm.name} needs {need}, and {self._visits.name} has none; make them")
        if (need, read) not in self._artifacts:
            self._artifacts[need, read] = read(self._files[need])
        return cast(Artifact, self._artifacts[need, read])

    def visit(self, name: str, reachable: np.ndarray) -> Visit:
        """Return the recorded visit of that name, with the positions (K, 2) that can be reached in it.

        It has no frames for an arm that needs neither tours, maps, detections nor segments.
        """
        if any(self._needs(need) for need in (Need.TOURS, Need.MAPS, Need.DETECTIONS, Need.SEGMENTS)):
            from ovman.evaluation.recorded_tours import load_visit

            return load_visit(self._recording(name), self._field_of_view_deg, reachable)
        return Visit((), reachable)

    def cache_key(self, visits: Sequence[str], phrase: str) -> dict[str, Any]:
        """Return everything of the observations of these visits that the arm's answer can depend on, JSON-serialisable."""
        key: dict[str, Any] = {}
        if self._needs(Need.TOURS):
            key["tours"] = [self._content(name) for name in visits]
        if self._needs(Need.MAPS):
            key["maps"] = [[_numbers(cluster) for cluster in self.perceived.maps[name]] for name in visits]
        if self._needs(Need.DETECTIONS):
            key["detections"] = [self.detected[name].content for name in visits]
        if any(self._needs(need) for need in (Need.MAPS, Need.DETECTIONS, Need.SEGMENTS)):
            key["noun"] = self.noun(phrase).tolist()
        for need in (Need.MAINTAINED, Need.DUALMAP, Need.SEGMENTS):
            if self._needs(need):
                key[need] = self.load_artifact(need, _digest_file)
        if self._needs(Need.NETWORKS):
            key["networks"] = self._network_files
        return key

    @cached_property
    def _networks(self) -> tuple[Detector, Encoder]:
        from ovman.perception.networks import detector_of, encoder_of

        return detector_of(self._settings.perception), encoder_of(self._settings.perception)

    @cached_property
    def _maps_by_content(self) -> Mapping[str | None, Sequence[Cluster]]:
        """The scene's maps. Names of visits reveal the change, so an agent does not learn them."""
        return {self._content(name): clusters for name, clusters in self.perceived.maps.items()}

    @cached_property
    def _detected_by_content(self) -> Mapping[str | None, Detected]:
        return {self._content(name): seen for name, seen in self.detected.items()}

    @cached_property
    def _network_files(self) -> object:
        from ovman.perception.networks import looked_at_by

        return looked_at_by(self._settings.perception)

    @cached_property
    def _nouns(self) -> Mapping[str, np.ndarray]:
        return read_nouns(self._files[NOUNS])

    def _content(self, name: str) -> str:
        from ovman.evaluation.recorded_tours import digest_tour

        return digest_tour(self._recording(name), self._field_of_view_deg)

    def _recording(self, name: str) -> Path:
        return self._elsewhere.get(name, tour_path(self._visits, name))

    def _needs(self, need: Need) -> bool:
        return need in self._arm.needs

    def _check_need(self, need: Need) -> None:
        if not self._needs(need):
            raise ValueError(f"arms.{self._arm.name} is given no {need}; write needs: [{need}] in its entry")


def store_opener(
    arm: Arm, settings: Settings, visits: Path, perceived: Mapping[str, Path]
) -> Callable[[str, float], ObservationStore]:
    """Return the function from a scene and its camera's vertical field of view to the store. It keeps the last one alone.

    visits: folder of the recorded visits of all scenes. perceived: folders with a file of each scene, and the file of nouns.
    """

    @lru_cache(maxsize=1)
    def open_store(scene: str, field_of_view_deg: float) -> ObservationStore:
        files = {need: path if need == NOUNS else path / f"{scene}.npz" for need, path in perceived.items()}
        files = {need: path for need, path in files.items() if path.is_file()}
        return ObservationStore(arm, settings, field_of_view_deg, visits / scene, files)

    return open_store


def _numbers(cluster: Cluster) -> list[Any]:
    return [np.asarray(part).tolist() for part in (cluster.position, cluster.feature, cluster.track, cluster.views)]


def _digest_file(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()
