"""A control that answers with the largest difference between two tours, on paper and driving. What differs is the control's own.

Of the query it reads whether the relation asks for a past place, and nothing else: then it looks for what the first tour shows
and the second does not, otherwise for what the second shows and the first does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import lru_cache

import numpy as np

from ovman.agents.controls.samples import Shown, sampled, shown_at
from ovman.agents.interface import Abstention, AbstentionReason, Action, Answer, Observation, Query, Visit
from ovman.agents.pilot import Pilot
from ovman.records.prediction import as_recorded
from ovman.settings import Settings

Differs = Callable[[Shown, Settings], np.ndarray]
"""By how much (k,) a frame of the other tour says that something else is at k places: more than 0 if so, less if it is the same,
NaN where the frame says nothing. settings: controls.*."""


@dataclass(frozen=True)
class _Compared:
    """What an answer depends on: two tours by what they show, which of them has what is looked for, how they are compared."""

    past: bool
    contents: tuple[str | None, str | None]
    differs: Differs
    constants: tuple[tuple[str, float], ...]
    tours: tuple[Visit, Visit] = field(compare=False, repr=False)
    settings: Settings = field(compare=False, repr=False)


def answer(past: bool, first: Visit, second: Visit, differs: Differs, settings: Settings) -> Answer | Abstention:
    """The place of the largest connected difference in any one frame: the median of its points on the floor plane.

    Something else is where more frames of the other tour say so than say that it is the same.
    past: whether what the first tour shows is looked for. Of equal differences the first is taken. Abstains with NO_CANDIDATE
    where nothing differs. settings: controls.*. Recorded tours are compared once, under whatever seeds a run asks again.
    """
    contents = first.content, second.content
    compared = _Compared(past, contents, differs, tuple(settings.controls), (first, second), settings)
    return _compare(compared) if None in contents else _compare_once(compared)


def _compare(compared: _Compared) -> Answer | Abstention:
    (first, second), settings, differs = compared.tours, compared.settings, compared.differs
    every_px = settings.controls.every_px
    here, there = (sampled(visit, every_px) for visit in ((first, second) if compared.past else (second, first)))
    most, place = 0, None
    for sample in here:
        votes = np.zeros(sample.depth.shape)
        for shown in shown_at(sample, there, every_px, settings.controls.changed_m):
            votes.reshape(-1)[shown.which] += np.nan_to_num(np.sign(differs(shown, settings)))
        part = _largest((votes > 0) & np.isfinite(sample.depth))
        if (size := int(np.count_nonzero(part))) > most:
            most, place = size, np.median(sample.points[part], axis=0)
    if place is None:
        return Abstention(AbstentionReason.NO_CANDIDATE)
    return Answer(float(place[0]), float(place[2]))


_compare_once = lru_cache(maxsize=1024)(_compare)


def _largest(mask: np.ndarray) -> np.ndarray:
    """The largest part of a mask whose cells touch, at corners as well; of equal ones the first."""
    if not mask.any():
        return mask
    from scipy.ndimage import label

    parts, _ = label(mask, structure=np.ones((3, 3), bool))
    part: np.ndarray = parts == np.bincount(parts[mask]).argmax()
    return part


class DifferenceAgent:
    """A control that drives to where the tours differ most. It takes no images while it drives."""

    looks = False

    def __init__(self, pilot: Pilot, differs: Differs, settings: Settings) -> None:
        self._pilot, self._differs, self._settings = pilot, differs, settings

    def familiarise(self, visit: Visit) -> None:
        """Keeps the first tour."""
        self._first = visit

    def revisit(self, visit: Visit) -> None:
        """Keeps the second tour."""
        self._second = visit

    def ask(self, query: Query) -> None:
        """Compares the tours once."""
        self._goal = as_recorded(answer(query.relation.past, self._first, self._second, self._differs, self._settings))
        self._pilot.set_out(self._second.reachable, query.relation)

    def act(self, observation: Observation) -> Action:
        """One primitive towards the difference; ABSTAIN without one."""
        if isinstance(self._goal, Abstention):
            return Action.ABSTAIN
        return self._pilot.act(observation, (self._goal.x, self._goal.z))
