"""The input of a form: type, size, asset and evidence of its surroundings, without the floor plan itself."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from ovman_engine.shapes.style import Style


class Insert(NamedTuple):
    """A thing set into a piece of furniture or resting on it; metres, in the frame of `Subject`.

    It is a drawer, door or shelf that is an object of its own, a sink that hangs into it, or an object that rests on it.
    """

    kind: str
    """drawer, door, shelf, sink or rest"""
    x0: float
    x1: float
    y0: float
    y1: float
    z0: float
    z1: float


@dataclass(frozen=True)
class Subject:
    """The object to be formed, in its own frame: x sideways, y up from 0 to h, z from the back -d/2 to the front d/2; metres."""

    type: str
    w: float
    h: float
    d: float
    style: Style
    inserts: tuple[Insert, ...] = ()
    hung: bool = False
    """Whether the object does not reach the floor, so that it has no legs"""
    true: tuple[float, float, float] | None = None
    """Width, height, depth of the object itself. A form of a slightly other size must not choose another variant"""

    @property
    def along_x(self) -> bool:
        """Whether the object is at least as wide as deep."""
        w, _, d = self.true or (self.w, self.h, self.d)
        return w >= d

    @property
    def elongation(self) -> float:
        """Longer over shorter side of the object's footprint."""
        w, _, d = self.true or (self.w, self.h, self.d)
        return max(w, d) / min(w, d)

    @property
    def slenderness(self) -> float:
        """Height of the object over the longer side of its footprint."""
        w, h, d = self.true or (self.w, self.h, self.d)
        return h / max(w, d)

    @property
    def x(self) -> float:
        """Half its width."""
        return self.w / 2

    @property
    def z(self) -> float:
        """Half its depth."""
        return self.d / 2

    def of_size(self, w: float, h: float, d: float) -> Subject:
        """Return the same asset asked for in another size, its inserts scaled with it."""
        kx, ky, kz = w / self.w, h / self.h, d / self.d
        inserts = tuple(Insert(i.kind, i.x0 * kx, i.x1 * kx, i.y0 * ky, i.y1 * ky, i.z0 * kz, i.z1 * kz) for i in self.inserts)
        return Subject(self.type, w, h, d, self.style, inserts, self.hung, self.true or (self.w, self.h, self.d))
