"""The contexts that agents are made with: the protocols of `ovman.agents.interface`, implemented."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from ovman.agents.interface import VISITS, Mapper, PrivilegedAnswer, Visit
from ovman.agents.pilot import Pilot
from ovman.evaluation.observations import ObservationStore
from ovman.evaluation.true_grounding import (
    grounding_by_labels,
    grounding_by_places,
    grounding_by_truth,
    read_looks,
    recorded_positions,
)
from ovman.perception.clusters import ObjectMap
from ovman.perception.labels import Labels
from ovman.perception.records import Detected
from ovman.records.episode import Episode
from ovman.records.prediction import Abstention, Answer
from ovman.records.scene import Scene
from ovman.records.task import WorldState
from ovman.records.visit import Sighting, Sightings, VisitPair
from ovman.settings import Arm, Need, Reading, Settings, Source
from ovman.task import recorded_world

if TYPE_CHECKING:
    from ovman.perception.detector import Detector
    from ovman.perception.encoder import Encoder

Made = TypeVar("Made")


@dataclass(frozen=True, slots=True, eq=False)
class RolloutContext:
    """An `AgentContext`. Functions refuse, in one line, what the arm does not need. privileged: None except for the oracle."""

    rng: np.random.Generator
    settings: Settings
    pilot: Pilot
    mapper: Mapper
    detections: Callable[[Visit], Detected]
    made: Callable[[Need, Callable[[Path], Any]], Any]
    noun: Callable[[str], np.ndarray]
    networks: Callable[[], tuple[Detector, Encoder]]
    privileged: PrivilegedAnswer | None = None
    answered: Answer | Abstention | None = None


@dataclass(frozen=True, slots=True, eq=False)
class EpisodeContext:
    """A `PredictionContext` of an episode.

    Of a visit that is withheld from the arm, map, tour and world are empty, and nothing is read.

    Attributes:
        sightings: None for an arm without oracle positions and without oracle grounding by positions.
        labels: Of the detections of the scene's visits by their names; None for an arm without oracle grounding by them.
        scene: The untouched scene; None for an arm that does not need it.
    """

    rng: np.random.Generator
    run: int
    settings: Settings
    episode: Episode
    arm: Arm
    store: ObservationStore
    sightings: Sightings | None = None
    labels: Mapping[str, Labels] | None = None
    scene: Scene | None = None

    @property
    def reachable(self) -> np.ndarray:
        """See `PredictionContext.reachable`."""
        box = self.episode.reachable_box
        return np.array(list(zip(box.x, box.z, strict=True)))

    @property
    def spawn(self) -> np.ndarray:
        """See `PredictionContext.spawn`."""
        return np.array((self.episode.spawn.x, self.episode.spawn.z))

    @property
    def grid(self) -> np.ndarray:
        """See `PredictionContext.grid`."""
        return np.array(self._untouched.reachable).reshape(-1, 2)

    @property
    def looks(self) -> Mapping[str, str]:
        """See `PredictionContext.looks`."""
        self._privileged(self.arm.positions, "positions")
        return read_looks(self._untouched)

    @property
    def visits(self) -> VisitPair[str]:
        """See `PredictionContext.visits`."""
        return self.episode.visits

    @property
    def privileged_grounding(self) -> bool:
        """See `PredictionContext.privileged_grounding`."""
        return self.arm.grounding is Source.HANDED

    def map(self, which: str) -> ObjectMap:
        """See `PredictionContext.map`."""
        if self._is_withheld(which):
            return ObjectMap.of(())
        return self.store.perceived.map(self.visits[which])

    def detections(self, which: str) -> Detected:
        """See `PredictionContext.detections`."""
        if self._is_withheld(which):
            return nothing_detected()
        return self.store.detected[self.visits[which]]

    def true_detections(self, which: str) -> Detected:
        """See `PredictionContext.true_detections`."""
        self._privileged(self.arm.positions, "positions")
        return self.store.true_detections(self.visits[which])

    def made(self, need: Need, read: Callable[[Path], Made]) -> Made:
        """See `PredictionContext.made`. ValueError for an arm from which a visit is withheld: files hold both."""
        if self.arm.withheld is not None and self.arm.withheld.visit is not None:
            raise ValueError(f"arms.{self.arm.name} is withheld the {self.arm.withheld.visit} visit; ask for its map or its tour")
        return self.store.load_artifact(need, read)

    def tour(self, which: str) -> Visit:
        """See `PredictionContext.tour`."""
        if self._is_withheld(which):
            return Visit((), self.reachable)
        return self.store.visit(self.visits[which], self.reachable)

    def noun(self, phrase: str) -> np.ndarray:
        """See `PredictionContext.noun`."""
        return self.store.noun(phrase)

    def networks(self) -> tuple[Detector, Encoder]:
        """See `PredictionContext.networks`."""
        return self.store.networks()

    def true_objects(self, objects: ObjectMap, *visits: str) -> tuple[int, ...]:
        """See `PredictionContext.true_objects`."""
        if self.arm.reads_labels:
            return grounding_by_labels(self.episode.category, objects.members, self._labels(visits), self.arm.reading)
        sightings = self._privileged(self.arm.grounding, "grounding")
        min_mask_px, radius_m = self.settings.admissibility.min_mask_px, self.episode.protocol.success.radius_m
        if self.arm.reading is Reading.PLACES:
            recorded = [recorded_positions(sightings[which], min_mask_px) for which in VISITS]
            return grounding_by_places(np.concatenate(recorded), objects.p, radius_m)
        meant = [grounding_by_truth(recorded_positions(sightings[which], min_mask_px), objects.p, radius_m) for which in visits]
        return tuple(sorted({index for of_visit in meant for index in of_visit}))

    def world(self, which: str) -> WorldState:
        """See `PredictionContext.world`."""
        sightings = self._privileged(self.arm.positions, "positions")[which]
        if self._is_withheld(which):
            return WorldState(())
        return recorded_world(sightings, self.episode.category, self.settings.admissibility.min_mask_px)

    @property
    def _untouched(self) -> Scene:
        if Need.SCENE not in self.arm.needs:
            raise ValueError(f"arms.{self.arm.name} is given no scene; write needs: [scene] in its entry")
        if self.scene is None:
            raise ValueError(f"arms.{self.arm.name} needs the record of {self.episode.scene}; make the stage scenes")
        return self.scene

    def _is_withheld(self, which: str) -> bool:
        return self.arm.withheld is not None and self.arm.withheld.visit == which

    def _labels(self, visits: Sequence[str]) -> list[Labels]:
        if self.labels is None or any(self.visits[which] not in self.labels for which in visits):
            raise ValueError(
                f"arms.{self.arm.name} is given its grounding: it needs the labels of {self.episode.scene}; make them"
            )
        return [self.labels[self.visits[which]] for which in visits]

    def _privileged(self, source: Source, what: str) -> VisitPair[tuple[Sighting, ...]]:
        if source is not Source.HANDED:
            raise ValueError(f"arms.{self.arm.name} finds its {what} itself; a diagnostic arm says {what}: handed in its entry")
        if self.sightings is None:
            raise ValueError(f"arms.{self.arm.name} is given its {what}: it needs the file of sightings beside the episodes")
        return self.sightings.sightings


def nothing_detected() -> Detected:
    """Return the detections of a visit that showed nothing."""
    nothing = np.zeros(0, np.int64)
    return Detected(
        nothing, np.zeros((0, 3)), np.zeros((0, 0)), nothing, np.zeros(0, np.float32), lambda: np.zeros((0, 0, 0), bool), ""
    )


def agent_settings(episode: Episode, settings: Settings) -> Settings:
    """Return the settings that an agent may read: those of its arm, with the episode's camera and primitives."""
    return replace_sections(settings, {name: dict(getattr(episode.protocol, name)) for name in ("camera", "primitives")})


def run_settings(episode: Episode, settings: Settings) -> Settings:
    """Return the settings that a run is measured by: those of its arm, with the episode's protocol and backend."""
    sections = {name: dict(getattr(episode.protocol, name)) for name in type(episode.protocol).model_fields}
    return replace_sections(settings, sections | {"benchmark": {"backend": episode.backend}})


def replace_sections(settings: Settings, sections: Mapping[str, Mapping[str, Any]]) -> Settings:
    """Return settings with other constants in these sections."""
    constants = {key: value for key, value in settings.constants().items() if key.partition(".")[0] not in sections}
    others = {f"{section}.{key}": value for section, values in sections.items() for key, value in values.items()}
    return settings.partial(constants | others)
