"""Recorded tours: what was seen (visit.json, "ovman-visit/2"), digests of their files, and sightings of instances.

A recorded tour is a directory, results/visits/{scene}/{visit}/. Its files.json has the SHA-256 of every other file; readers
verify it. The manifest has one digest per tour and Snakemake compares it; the tours themselves are kept from run to run, and
Snakemake never deletes them. Sightings are given to diagnostic arms alone.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Generic, Literal, Self, TypeVar

from pydantic import Field

from ovman.records.geometry import Position
from ovman.records.record import Count, Name, Record, RecordError, Text
from ovman.records.scene import Alteration, MoverRecord

T = TypeVar("T")


class Sighting(Record):
    """One instance in one view of a tour: size of its mask in pixels, and its floor-plane position in metres at that view."""

    view: Count
    instance: Text
    px: Count
    x: float
    z: float


class VisitPair(Record, Generic[T]):
    """Something of the two visits of an episode."""

    first: T
    second: T

    def __getitem__(self, which: str) -> T:
        """Return the value of visit "first" or "second"."""
        return {"first": self.first, "second": self.second}[which]


class Sightings(Record):
    """The sightings of the instances of an episode's category in both tours, "ovman-sightings/1"."""

    schema_id: Literal["ovman-sightings/1"] = Field("ovman-sightings/1", alias="schema")
    episode: Text
    sightings: VisitPair[tuple[Sighting, ...]]


MILLIMETRES = 1000.0
"""Millimetres in a metre: depth pictures are in millimetres."""
FILES = "files.json"
"""Name of the file that has the digests of all others."""


class TourError(ValueError):
    """A recorded tour that cannot be used; one line with the file, what is wrong with it, and the command that mends it."""

    says_all = True


REMEDY = "record it again: snakemake --cores 2 --forcerun trials"
"""What to do about a missing or damaged tour."""


class VisitFiles(Record):
    """The files of a recorded tour, "ovman-visit-files/1".

    key: digest of all that the recording depends on. sha256: of each file, by its name, in hexadecimal.
    """

    schema_id: Literal["ovman-visit-files/1"] = Field("ovman-visit-files/1", alias="schema")
    key: str
    sha256: Mapping[Name, Text]

    @classmethod
    def load(cls, directory: Path) -> Self:
        """Return the digests of the tour in `directory`. TourError where they are not there or are torn."""
        file = directory / FILES
        try:
            return cls.parse(file.read_bytes())
        except (OSError, RecordError) as error:
            why = error.strerror if isinstance(error, OSError) else "torn"
            raise TourError(f"{file}: {why}; {REMEDY}") from None

    @property
    def content(self) -> str:
        """One digest of all files: tours of equal content have equal digests."""
        text = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(self.sha256.items()))
        return hashlib.sha256(text.encode()).hexdigest()


def seal(directory: Path, key: str = "") -> VisitFiles:
    """Write the digests of all files of a directory, sorted by name, into its files.json. key: as `VisitFiles.key`."""
    files = sorted(path for path in directory.iterdir() if path.name != FILES)
    made = VisitFiles(key=key, sha256={path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in files})
    (directory / FILES).write_text(made.to_line(), encoding="utf-8")
    return made


def read_verified(path: Path, files: VisitFiles | None = None) -> bytes:
    """Return the content of a file of a recorded tour. files: of its tour, if they were loaded already.

    TourError where the file is missing, or is not what was recorded.
    """
    directory = path.parent
    try:
        content = path.read_bytes()
    except OSError as error:
        raise TourError(f"{path}: {error.strerror}; {REMEDY}") from None
    recorded = (files or VisitFiles.load(directory)).sha256.get(path.name)
    if recorded is None:
        raise TourError(f"{path}: not among the recorded files; {REMEDY}")
    if hashlib.sha256(content).hexdigest() != recorded:
        raise TourError(f"{path}: its content is not what was recorded; {REMEDY}")
    return content


def kept(directory: Path, key: str) -> bool:
    """Return whether a whole recording of that key lies in `directory`. Prints what is damaged."""
    if not directory.exists():
        return False
    try:
        files = VisitFiles.load(directory)
        for name in files.sha256 if files.key == key else ():
            read_verified(directory / name, files)
    except TourError as error:
        print(error, flush=True)
        return False
    return files.key == key


class VisitManifest(Record):
    """The recorded tours of a scene, "ovman-visits/1": one digest of content (`VisitFiles.content`) per tour, by name."""

    schema_id: Literal["ovman-visits/1"] = Field("ovman-visits/1", alias="schema")
    scene: Name
    visits: Mapping[Name, Text]

    def directory(self, visits: Path, name: str) -> Path:
        """Return the directory of a tour of that name. visits: of the recorded tours of all scenes.

        TourError where the manifest does not have the tour, or another recording lies there.
        """
        directory = visits / self.scene / name
        if name not in self.visits:
            raise TourError(f"{directory}: not in the manifest of the scene's tours; {REMEDY}")
        if VisitFiles.load(directory).content != self.visits[name]:
            raise TourError(f"{directory}: another recording than the manifest's; {REMEDY}")
        return directory


class Present(Record):
    """A dynamic instance at the beginning of the tour: its category and its position in metres."""

    category: Text
    position: Position


class ViewPose(Record):
    """The agent's pose at a view: metres, degrees; a positive horizon looks down."""

    x: float
    z: float
    yaw_deg: float
    horizon_deg: float


class SensedPose(Record):
    """The sensed pose of an agent and of its camera."""

    pose: ViewPose
    camera: Position


class View(Record):
    """One view of a tour.

    camera: position of the camera in metres. sensed: what an agent is told instead of both, None where its sensors are exact.
    instances: ids by the values 1, 2, ... of the index picture. seen: sizes in pixels of the masks that are large enough to
    be written down. moved: positions of the instances that moved since the last view.
    """

    pose: ViewPose
    camera: Position
    sensed: SensedPose | None = None
    instances: tuple[str, ...]
    seen: Mapping[str, Count]
    moved: Mapping[str, Position]


class Visit(Record):
    """A recorded visit. Positions are centres of axis-aligned boxes, metres."""

    schema_id: Literal["ovman-visit/2"] = Field("ovman-visit/2", alias="schema")
    scene: Name
    visit: Name
    alterations: tuple[Alteration, ...]
    placed: Mapping[str, Position]
    present: Mapping[str, Present]
    movers: tuple[MoverRecord, ...]
    views: tuple[View, ...]

    @classmethod
    def load(cls, directory: Path) -> Self:
        """Return the record of the visit in `directory`.

        TourError where it is missing or is not what was recorded, RecordError where it is not what its schema says.
        """
        file = directory / "visit.json"
        return cls.parse(read_verified(file).decode(), str(file))

    @cached_property
    def positions(self) -> tuple[Mapping[str, Position], ...]:
        """Position of every present dynamic instance at each view."""
        here: Mapping[str, Position] = {k: v.position for k, v in self.present.items()}
        at_views = []
        for view in self.views:
            here = {**here, **view.moved}
            at_views.append(here)
        return tuple(at_views)

    def largest_px(self, instance: str) -> int:
        """Return the size of the largest mask of an instance in the tour, pixels; 0 where none was written down."""
        return max((view.seen.get(instance, 0) for view in self.views), default=0)

    def sightings(self, category: str) -> tuple[Sighting, ...]:
        """Return the views of the instances of a category, in the order of the tour."""
        return tuple(
            Sighting(view=i, instance=k, px=px, x=here[k].x, z=here[k].z)
            for i, (view, here) in enumerate(zip(self.views, self.positions, strict=True))
            for k, px in view.seen.items()
            if k in here and self.present[k].category == category
        )
