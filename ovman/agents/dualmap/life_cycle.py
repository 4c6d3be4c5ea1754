"""The life cycle of an object in the local map: updated, then either waiting and kept, or pending and removed.

Source: the object status of DualMap's local map.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ovman.agents.dualmap.settings import DualmapLife


class Phase(StrEnum):
    """Phase of an object.

    UPDATING: seen within the window. PENDING: unstable and not seen within it. WAITING: stable and not seen within it. SETTLED:
    has waited long enough and is final. GONE: was pending for too long.
    """

    UPDATING = "updating"
    PENDING = "pending"
    WAITING = "waiting"
    SETTLED = "settled"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class Stage:
    """A phase and its duration in keyframes."""

    phase: Phase = Phase.UPDATING
    frames: int = 0


def advanced(stage: Stage, missed: int, stable: bool, constants: DualmapLife) -> Stage:
    """The stage of an object after a keyframe.

    missed: keyframes since the last observation, 0 if this one has it; stable: as ``is_stable``.
    """
    if missed <= constants.window:
        return Stage()
    if stage.phase is Phase.UPDATING:
        return Stage(Phase.WAITING if stable else Phase.PENDING, 1)
    frames = stage.frames + 1
    if stage.phase is Phase.PENDING and frames > constants.pending:
        return Stage(Phase.GONE)
    if stage.phase is Phase.WAITING and frames > constants.waiting:
        return Stage(Phase.SETTLED)
    return Stage(stage.phase, frames)


def flush_frames(constants: DualmapLife) -> int:
    """Number of empty keyframes after which every object has settled or gone."""
    return constants.window + max(constants.pending, constants.waiting) + 1


def is_stable(classes: Sequence[int], confidences: Sequence[float], kinds: int, constants: DualmapLife) -> bool:
    """Whether an object was observed often enough and with a consistent class.

    classes, confidences: of its observations in their order; kinds: number of classes.
    """
    if len(classes) < constants.stable:
        return False
    _, most = Counter(classes).most_common(1)[0]
    return most * constants.majority_one_in > len(classes) or converged(classes, confidences, kinds, constants)


def converged(classes: Sequence[int], confidences: Sequence[float], kinds: int, constants: DualmapLife) -> bool:
    """Whether a Bayes filter over an object's class has converged.

    The likelihood of an observation is its confidence for its own class; the others share the rest equally. The prior over the
    `kinds` classes is uniform.
    """
    history = _posteriors(classes, confidences, kinds)
    greatest = history.max(axis=1)
    last = history[-1]
    entropy = -float(np.sum(last * np.log(np.maximum(last, 1e-300))))
    recent = greatest[-constants.filter_span :]
    return bool(
        greatest[-1] > constants.filter_probability
        and entropy < constants.filter_entropy
        and len(recent) == constants.filter_span
        and recent.max() - recent.min() < constants.filter_change
    )


def _posteriors(classes: Sequence[int], confidences: Sequence[float], kinds: int) -> np.ndarray:
    """(N, kinds) probabilities of the classes after each of N observations."""
    kinds = max(kinds, max(classes) + 1, 2)
    likelihood = np.empty((len(classes), kinds))
    sure = np.clip(np.asarray(confidences, dtype=np.float64), 1e-6, 1 - 1e-6)
    likelihood[:] = ((1 - sure) / (kinds - 1))[:, None]
    likelihood[np.arange(len(classes)), list(classes)] = sure
    log = np.cumsum(np.log(likelihood), axis=0)
    log -= log.max(axis=1, keepdims=True)
    weight = np.exp(log)
    probabilities: np.ndarray = weight / weight.sum(axis=1, keepdims=True)
    return probabilities
