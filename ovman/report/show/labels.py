"""Placement of the words of a drawing, so that they hide neither each other nor what they name."""

from __future__ import annotations

from dataclasses import dataclass, field

Point = tuple[float, float]
WIDTH_OF_A_CHARACTER = 0.62
"""Of a bold sans-serif letter, in units of its size."""
_SIDES = ((1, 0), (1, -1), (1, 1), (-1, 0), (-1, -1), (-1, 1), (0, -1), (0, 1))
_FARTHER = (1.0, 1.7, 2.6)


@dataclass(frozen=True, slots=True)
class Box:
    """An upright rectangle by its corners, u to the right and v down."""

    left: float
    top: float
    right: float
    bottom: float

    @staticmethod
    def around(at: Point, half_width: float, half_height: float) -> Box:
        """The box around a middle."""
        return Box(at[0] - half_width, at[1] - half_height, at[0] + half_width, at[1] + half_height)

    @property
    def middle(self) -> Point:
        """Its centre."""
        return (self.left + self.right) / 2, (self.top + self.bottom) / 2

    def overlap(self, other: Box) -> float:
        """Area that two boxes share."""
        wide = min(self.right, other.right) - max(self.left, other.left)
        high = min(self.bottom, other.bottom) - max(self.top, other.top)
        return max(wide, 0.0) * max(high, 0.0)


@dataclass
class Labels:
    """Places words beside points, one after the other, each where it overlaps least with what is taken already."""

    width: float
    height: float
    taken: list[Box] = field(default_factory=list)

    def keep(self, at: Point, radius: float) -> None:
        """Take the disc, so that no words are placed over it."""
        self.taken.append(Box.around(at, radius, radius))

    def place(self, at: Point, radius: float, words: str, size: float, padding: float = 1.0) -> Box:
        """The box of words of a letter size beside a disc at `at`; the box is taken from now on."""
        half_width = len(words) * size * WIDTH_OF_A_CHARACTER / 2 + padding
        half_height = size * 0.6 + padding

        def candidate(side: Point, factor: float) -> Box:
            reach = radius * factor + 1.5
            u = at[0] + side[0] * (reach + half_width)
            v = at[1] + side[1] * (reach + half_height if not side[0] else 0.7 * reach + half_height)
            return Box.around((u, v), half_width, half_height)

        boxes = [candidate(side, factor) for factor in _FARTHER for side in _SIDES]
        best = min(boxes, key=self._cost)
        self.taken.append(best)
        return best

    def _cost(self, box: Box) -> float:
        outside = max(-box.left, 0) + max(-box.top, 0) + max(box.right - self.width, 0) + max(box.bottom - self.height, 0)
        return sum(box.overlap(other) for other in self.taken) + 100 * outside
