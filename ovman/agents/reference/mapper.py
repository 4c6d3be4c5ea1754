"""What turns a visit into the clusters of its map."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

from ovman.agents.interface import Observation, Visit
from ovman.perception.backprojection import Camera
from ovman.perception.clusters import Cluster
from ovman.perception.maps import mapped
from ovman.perception.protocols import ImageEncoder, Segmenter
from ovman.perception.tour import View, detections


class Mapper(Protocol):
    """The eyes of the reference agent."""

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of a visit's map."""


class KeptMaps:
    """Maps that were made of known tours, found again by what the tours show. No frame is looked at.

    maps: clusters by the content of the tour (``Visit.content``).
    """

    def __init__(self, maps: Mapping[str, Sequence[Cluster]]) -> None:
        self._maps = dict(maps)

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of the visit's map. ValueError for a tour of which no map was made."""
        if visit.content is None or visit.content not in self._maps:
            raise ValueError(f"no map was made of the tour with the content {visit.content}; make the stage maps again")
        return self._maps[visit.content]


@dataclass(frozen=True, slots=True)
class SeenMaps:
    """Maps that are made of whatever tour is seen: each of its frames goes through the networks.

    detector, encoder: the networks (``ovman.perception.networks``); min_mask_px, crop_padding, radius_m: as in the sections
    perception and maps of config.yaml.
    """

    detector: Segmenter
    encoder: ImageEncoder
    min_mask_px: int
    crop_padding: float
    radius_m: float

    def __call__(self, visit: Visit) -> Sequence[Cluster]:
        """The clusters of the visit's map. ValueError for a visit without images."""
        views = [_view(observation) for observation in visit.observations]
        return mapped(detections(views, self.detector, self.encoder, self.min_mask_px, self.crop_padding), self.radius_m)


def _view(observation: Observation) -> View:
    if observation.rgb is None or observation.depth is None:
        raise ValueError("a frame of the tour has no image; a map is made of images")
    pose = observation.pose
    camera = Camera((pose.x, pose.y, pose.z), pose.yaw_deg, pose.horizon_deg, observation.field_of_view_deg)
    return View(observation.rgb, observation.depth, camera)
