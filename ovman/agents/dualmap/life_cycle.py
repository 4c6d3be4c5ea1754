"""The life of an object in the local map: it is updated, then either waits and stays or is pending and goes.

Source: the object status of DualMap's local map.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from ovman.models.settings.baselines import DualmapLife


class Phase(StrEnum):
    """UPDATING: seen within the window. PENDING: out of it and unstable. WAITING: out of it and stable. SETTLED: has waited, so
    that the local map has no more to do with it. GONE: was pending for too long.
    """

    UPDATING = "updating"
    PENDING = "pending"
    WAITING = "waiting"
    SETTLED = "settled"
    GONE = "gone"


@dataclass(frozen=True, slots=True)
class Stage:
    """A phase, and for how many keyframes it has lasted."""

    phase: Phase = Phase.UPDATING
    frames: int = 0


def advanced(stage: Stage, missed: int, stable: bool, constants: DualmapLife) -> Stage:
    """The stage of an object after a keyframe.

    missed: keyframes since it was last seen, 0 where this one shows it; stable: as ``is_stable`` has it.
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
    """Whether an object was observed often enough, and as what it is.

    classes, confidences: of its observations in their order; kinds: how many classes there are.
    """
    if len(classes) < constants.stable:
        return False
    _, most = Counter(classes).most_common(1)[0]
    return most * constants.majority_one_in > len(classes) or converged(classes, confidences, kinds, constants)


def converged(classes: Sequence[int], confidences: Sequence[float], kinds: int, constants: DualmapLife) -> bool:
    """Whether a Bayes filter over an object's class has come to rest.

    Each observation has the likelihood of its confidence for its own class, and the rest shared out equally among the others;
    before the first all of the `kinds` classes are as likely.
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
