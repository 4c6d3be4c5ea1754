"""Recorded tours: what was seen (visit.json, "ovman-visit/2"), digests of their files, and sightings of instances.

A recorded tour is one file, results/visits/{scene}/{visit}.zip, without compression of its own. Its files.json has the SHA-256
of every other file in it; readers verify it. The manifest has one digest per tour and Snakemake compares it; the tours themselves
are kept from run to run, and Snakemake never deletes them. Sightings are given to diagnostic arms alone.
"""

from __future__ import annotations

import hashlib
import io
import zipfile
from collections.abc import Mapping
from functools import cached_property, lru_cache
from pathlib import Path
from typing import Generic, Literal, Self, TypeVar

from pydantic import Field

from ovman.atomic import replacing
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
RECORD = "visit.json"
"""Name of the file that has the record of the visit."""


class TourError(ValueError):
    """A recorded tour that cannot be used; one line with the file, what is wrong with it, and the command that mends it."""

    says_all = True


REMEDY = "record it again: snakemake --cores 2 --forcerun tours"
"""What to do about a missing or damaged tour."""


class VisitFiles(Record):
    """The files of a recorded tour, "ovman-visit-files/1".

    key: digest of all that the recording depends on. sha256: of each file, by its name, in hexadecimal.
    """

    schema_id: Literal["ovman-visit-files/1"] = Field("ovman-visit-files/1", alias="schema")
    key: str
    sha256: Mapping[Name, Text]

    @classmethod
    def load(cls, tour: Path) -> Self:
        """Return the digests of a recorded tour. TourError where it is not there or is torn."""
        try:
            return cls.parse(_member(tour, FILES))
        except RecordError:
            raise TourError(f"{tour}: its {FILES} is torn; {REMEDY}") from None

    @property
    def content(self) -> str:
        """One digest of all files: tours of equal content have equal digests."""
        text = "".join(f"{sha256}  {name}\n" for name, sha256 in sorted(self.sha256.items()))
        return hashlib.sha256(text.encode()).hexdigest()


MADE = (1980, 1, 1, 0, 0, 0)
"""Date of all files in a tour, so that equal tours are equal files."""


def write_tour(tour: Path, contents: Mapping[str, bytes], key: str = "") -> VisitFiles:
    """Write the files of a recorded tour and their digests; it is whole or absent, also after a kill. key: of `VisitFiles`."""
    files = VisitFiles(key=key, sha256={name: hashlib.sha256(contents[name]).hexdigest() for name in sorted(contents)})
    with replacing(tour) as partial, zipfile.ZipFile(partial, "w") as archive:
        for name, content in sorted({**contents, FILES: files.to_line().encode()}.items()):
            archive.writestr(zipfile.ZipInfo(name, MADE), content)
    return files


def _member(tour: Path, name: str) -> bytes:
    """Return the content of a file in a recorded tour. TourError where it is missing or damaged."""
    try:
        stat = tour.stat()
        return _archive(tour, stat.st_mtime_ns, stat.st_size).read(name)
    except OSError as error:
        raise TourError(f"{tour}: {error.strerror}; {REMEDY}") from None
    except KeyError:
        raise TourError(f"{tour}: lacks {name}; {REMEDY}") from None
    except zipfile.BadZipFile:
        raise TourError(f"{tour}: its {name} is torn; {REMEDY}") from None


@lru_cache(maxsize=2)
def _archive(tour: Path, written_ns: int, size: int) -> zipfile.ZipFile:
    """Read a tour at once: its files are asked for one after the other, also by processes that share what is open."""
    return zipfile.ZipFile(io.BytesIO(tour.read_bytes()))


def read_verified(tour: Path, name: str, files: VisitFiles | None = None) -> bytes:
    """Return the content of a file of a recorded tour. files: of the tour, if they were loaded already.

    TourError where the file is missing, or is not what was recorded.
    """
    content = _member(tour, name)
    recorded = (files or VisitFiles.load(tour)).sha256.get(name)
    if recorded is None:
        raise TourError(f"{tour}: {name} is not among the recorded files; {REMEDY}")
    if hashlib.sha256(content).hexdigest() != recorded:
        raise TourError(f"{tour}: the content of {name} is not what was recorded; {REMEDY}")
    return content


def kept(tour: Path, key: str) -> bool:
    """Return whether a whole recording of that key lies in `tour`. Prints what is damaged."""
    if not tour.exists():
        return False
    try:
        files = VisitFiles.load(tour)
        for name in files.sha256 if files.key == key else ():
            read_verified(tour, name, files)
    except TourError as error:
        print(error, flush=True)
        return False
    return files.key == key


def picture_name(number: int, kind: str) -> str:
    """Return the name of a picture of a view in a tour. kind: "rgb", "depth" or "ids"."""
    return f"{number:02d}_{kind}.png"


def tour_path(visits: Path, name: str) -> Path:
    """Return where the tour of that name is recorded. visits: of the scene's recorded tours."""
    return visits / f"{name}.zip"


class VisitManifest(Record):
    """The recorded tours of a scene, "ovman-visits/1": one digest of content (`VisitFiles.content`) per tour, by name."""

    schema_id: Literal["ovman-visits/1"] = Field("ovman-visits/1", alias="schema")
    scene: Name
    visits: Mapping[Name, Text]

    def tour(self, visits: Path, name: str) -> Path:
        """Return the file of a tour of that name. visits: of the recorded tours of all scenes.

        TourError where the manifest does not have the tour, or another recording lies there.
        """
        tour = tour_path(visits / self.scene, name)
        if name not in self.visits:
            raise TourError(f"{tour}: not in the manifest of the scene's tours; {REMEDY}")
        if VisitFiles.load(tour).content != self.visits[name]:
            raise TourError(f"{tour}: another recording than the manifest's; {REMEDY}")
        return tour


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
    def load(cls, tour: Path) -> Self:
        """Return the record of a recorded visit.

        TourError where it is missing or is not what was recorded, RecordError where it is not what its schema says.
        """
        return cls.parse(read_verified(tour, RECORD).decode(), f"{RECORD} in {tour}")

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
