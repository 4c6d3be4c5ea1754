"""The joint agent with a part taken away, for what each part is worth."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ovman.agents.interface import Abstention, Answer, PredictionContext, Query
from ovman.agents.joint.answers import answer, recorded
from ovman.agents.joint.naming import Nouns
from ovman.agents.joint.segments import Segments
from ovman.agents.joint.settings import Joint

NEVER_TOGETHER = 1e-9
"""As `joint.feature_distance`: no two embeddings are so near to each other."""


def predict_without_identity(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Without asking whether a changed thing is elsewhere in the other visit: MOVED is APPEARED, FORMER is REMOVED."""
    return _asked(query, context, context.settings.joint.model_copy(update={"identity": 0.0}))


def predict_without_objects(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Without objects: every detection is a thing of its own."""
    return _asked(query, context, context.settings.joint.model_copy(update={"feature_distance": NEVER_TOGETHER}))


def predict_without_depth(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Without what the other tour's depth says of a place: what changed is what no detection there resembles."""
    return _asked(query, context, context.settings.joint, matched)


def matched(first: Segments, second: Segments, constants: Joint) -> tuple[Segments, Segments]:
    """Both visits' detections, changed by as much as the likest one at their place in the other visit is unlike them."""
    first, second = detections(first), detections(second)
    return _unmatched(first, second, constants), _unmatched(second, first, constants)


def detections(seen: Segments) -> Segments:
    """The segments that are detections."""
    return Segments(**{name: getattr(seen, name)[seen.named] for name in Segments.__slots__})


def _unmatched(mine: Segments, other: Segments, constants: Joint) -> Segments:
    apart = np.linalg.norm(mine.place[:, None] - other.place[None], axis=2)
    unlike = constants.likeness * (constants.alike - mine.feature @ other.feature.T)
    changed = np.where(apart <= constants.radius_m, unlike, -constants.unlike).min(axis=1, initial=-constants.unlike)
    return replace(mine, changed=np.maximum(changed, constants.unlike), moving=np.full(len(mine), constants.unlike))


Evidenced = Callable[[Segments, Segments, Joint], tuple[Segments, Segments]]


def _asked(
    query: Query, context: PredictionContext, constants: Joint, instead: Evidenced | None = None
) -> tuple[Answer | Abstention, None]:
    first, second = recorded(context)
    if instead is not None:
        first, second = instead(first, second, constants)
    return answer(query, first, second, Nouns(context.noun, constants), constants), None
