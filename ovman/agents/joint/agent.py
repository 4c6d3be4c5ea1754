"""The arms of the joint agent: it decides once on both tours, and follows what moves with its own eyes."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ovman.agents.interface import VISITS, Abstention, Action, Answer, Observation, PredictionContext, Query, Relation, Visit
from ovman.agents.joint import Joint
from ovman.agents.joint.decision import Nouns, Objects, answer, compare_objects, compare_places
from ovman.agents.joint.segments import (
    Frame,
    Segments,
    find_unnamed_parts,
    grid_frame,
    grid_frames,
    grid_votes,
    read_segments,
    select_segments,
)
from ovman.agents.pilot import GoalAgent
from ovman.agents.words import understands
from ovman.settings import Need, Settings

NEVER_TOGETHER = 1e-9
"""A `joint.feature_distance` that no two embeddings fall below."""

# Static arms ------------------------------------------------------------------------------------------------------------------


@understands
def predict(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer as the static arm joint. Reads joint.*."""
    return _predict(query, context, recorded_segments(context), context.settings.joint)


def predict_without_identity(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer without asking whether a changed thing is elsewhere in the other visit: MOVED is APPEARED, FORMER is REMOVED."""
    return _predict(query, context, recorded_segments(context), context.settings.joint, _tell_nothing_apart)


def predict_without_objects(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer without objects: every detection is a thing of its own."""
    constants = context.settings.joint.model_copy(update={"feature_distance": NEVER_TOGETHER})
    return _predict(query, context, recorded_segments(context), constants)


def predict_without_depth(query: Query, context: PredictionContext) -> tuple[Answer | Abstention, None]:
    """Answer without the other tour's depth: a detection has changed that no detection of the other tour resembles."""
    constants = context.settings.joint
    return _predict(query, context, compare_detections(*recorded_segments(context), constants), constants)


def _predict(
    query: Query,
    context: PredictionContext,
    segments: tuple[Segments, Segments],
    constants: Joint,
    compare: Callable[[Objects, Objects, Joint], np.ndarray] = compare_objects,
) -> tuple[Answer | Abstention, None]:
    return answer(query, *segments, Nouns(context.noun, constants), constants, compare), None


def _tell_nothing_apart(first: Objects, second: Objects, constants: Joint) -> np.ndarray:
    return np.full((len(first), len(second)), constants.unlike)


def recorded_segments(context: PredictionContext) -> tuple[Segments, Segments]:
    """Return the segments of both recorded visits, as the stage `segments` made them."""
    first, second = VISITS
    return select_segments(context.made(Need.SEGMENTS, read_segments), context.tour(first), context.tour(second))


def compare_detections(first: Segments, second: Segments, constants: Joint) -> tuple[Segments, Segments]:
    """Return both visits' detections, changed by how unlike the most similar one at their place in the other visit is."""
    first, second = _select_detections(first), _select_detections(second)
    return _unmatched(first, second, constants), _unmatched(second, first, constants)


def _select_detections(seen: Segments) -> Segments:
    return Segments(**{name: getattr(seen, name)[seen.named] for name in Segments.__slots__})


def _unmatched(mine: Segments, other: Segments, constants: Joint) -> Segments:
    changed = compare_places(mine, other, constants)
    return replace(mine, changed=changed, moving=changed)


# Embodied arm -----------------------------------------------------------------------------------------------------------------


class JointAgent(GoalAgent):
    """The arm joint_embodied. For MOVING alone it takes images while it drives; `looks` says so after `ask`."""

    pursuit: Pursuit | None = None

    def revisit(self, visit: Visit) -> None:
        """Weigh both tours against each other."""
        super().revisit(visit)
        self.segments = select_segments(self.context.made(Need.SEGMENTS, read_segments), self.first, visit)

    def decide(self, query: Query) -> Answer | Abstention:
        """Decide, and for MOVING get ready to look for what moves."""
        settings = self.context.settings
        goal = answer(query, *self.segments, Nouns(self.context.noun, settings.joint), settings.joint)
        self.pursuit = None
        if query.relation is Relation.MOVING and isinstance(goal, Answer):
            self.pursuit = Pursuit(self.second, (goal.x, goal.z), settings)
        self.looks = self.pursuit is not None
        return goal

    def act(self, observation: Observation) -> Action:
        """Return the next primitive towards the answer, or towards the last sighting of what it follows."""
        if self.pursuit is None:
            return super().act(observation)
        self.pursuit.look(observation)
        if self.pursuit.is_searching:
            return self.pursuit.turn()
        action = self.context.pilot.act(observation, self.pursuit.place)
        return self.pursuit.turn() if action is Action.STOP and self.pursuit.is_lost else action


class Pursuit:
    """Follows something that moves by depth alone. `place`: where it is thought to be, (x, z) in metres.

    visit: the tour in which it was seen last; place: where. settings: sections joint and primitives.
    """

    def __init__(self, visit: Visit, place: tuple[float, float], settings: Settings) -> None:
        self.place = place
        self._joint, self._turns = settings.joint, round(360 / settings.primitives.turn_deg)
        self._known: tuple[Frame, ...] = grid_frames(visit, self._joint)
        self._seen = False
        self._turned = 0

    def look(self, observation: Observation) -> None:
        """Take the nearest thing that stands where the tour saw through, if it is near enough to the thought place."""
        found = sorted(self._find_changes(observation), key=lambda place: math.dist(place, self.place))
        self._seen = bool(found) and math.dist(found[0], self.place) <= self._joint.pursuit_m
        if self._seen:
            self.place, self._turned = found[0], 0

    @property
    def is_lost(self) -> bool:
        """Whether it is out of sight, and the agent has not looked all around since it was seen last."""
        return not self._seen and self._turned < self._turns

    @property
    def is_searching(self) -> bool:
        """Whether a look around has begun and found nothing yet."""
        return self.is_lost and self._turned > 0

    def turn(self) -> Action:
        """Return the next turn of a look around."""
        self._turned += 1
        return Action.ROTATE_LEFT

    def _find_changes(self, observation: Observation) -> list[tuple[float, float]]:
        """Return the places (x, z) of what a frame shows where the tour saw through."""
        one = grid_frame(observation, self._joint)
        grid = grid_votes([one], self._known, self._joint)[0]
        parts = find_unnamed_parts(grid, np.zeros(one.known.shape, bool), self._joint)
        places = [np.median(one.points[part], axis=0) for part in parts]
        return [(float(place[0]), float(place[2])) for place in places]
