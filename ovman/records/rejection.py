"""Why a candidate is not an episode. Every reason has a name, and every name belongs to one stage of Algorithm 1."""

from __future__ import annotations

from enum import StrEnum


class RejectionStage(StrEnum):
    """The part of Algorithm 1 that rejects, in its order."""

    DRAW = "draw"  # lines 1 and 3: nothing to choose from
    PLACEMENT = "placement"  # line 3: the scripted change
    GEOMETRY = "geometry"  # line 4: reachable, mobile, visible
    OBSERVATION = "observation"  # lines 6 and 7: what the tours recorded
    CERTIFICATION = "certification"  # lines 8 and 9: the oracle's runs
    RELEASE = "release"  # lines 10 to 12: what is certified, but not independent of what is released
    SIMULATOR = "simulator"  # no verdict of the benchmark: the simulator failed


class Rejection(StrEnum):
    """The reasons in the order in which they are looked for: of several, the first is the one that is counted."""

    NO_PLACEMENT = "no_placement"
    CANNOT_MOVE = "cannot_move"
    NO_OTHERS = "no_others"
    NO_SPAWN = "no_spawn"
    PLACEMENT_REFUSED = "placement_refused"
    DISPLACEMENT_BELOW_MINIMUM = "displacement_below_minimum"
    SPAWN_TOO_CLOSE = "spawn_too_close"
    SPAWN_AT_ANSWER = "spawn_at_answer"
    SPAWN_IMMOBILE = "spawn_immobile"
    ANSWER_UNREACHABLE = "answer_unreachable"
    ANSWER_NOT_VISIBLE = "answer_not_visible"
    CROWDED = "crowded"
    OTHER_CHANGE_NEAR = "other_change_near"
    CHANGED_INSTANCE_NOT_RECORDED = "changed_instance_not_recorded"
    OTHER_CHANGE_NOT_RECORDED = "other_change_not_recorded"
    MOTION_NOT_RECORDED = "motion_not_recorded"
    ABOVE_CHANCE = "above_chance"
    REFERENT_ABSENT = "referent_absent"
    REFERENT_AMBIGUOUS = "referent_ambiguous"
    REFERENT_NOT_TARGET = "referent_not_target"
    BYSTANDER_MOVED = "bystander_moved"
    DRIFTED = "drifted"
    FEASIBILITY_FAILED = "feasibility_failed"
    CERTIFICATION_FAILED = "certification_failed"
    SHARED_TOURS = "shared_tours"
    SIMULATOR_ERROR = "simulator_error"

    @property
    def stage(self) -> RejectionStage:
        """The part of Algorithm 1 that rejects for this reason."""
        return _STAGES[self]


_STAGES = {
    Rejection.NO_PLACEMENT: RejectionStage.DRAW,
    Rejection.CANNOT_MOVE: RejectionStage.DRAW,
    Rejection.NO_OTHERS: RejectionStage.DRAW,
    Rejection.NO_SPAWN: RejectionStage.DRAW,
    Rejection.PLACEMENT_REFUSED: RejectionStage.PLACEMENT,
    Rejection.DISPLACEMENT_BELOW_MINIMUM: RejectionStage.PLACEMENT,
    Rejection.SPAWN_TOO_CLOSE: RejectionStage.PLACEMENT,
    Rejection.SPAWN_AT_ANSWER: RejectionStage.GEOMETRY,
    Rejection.SPAWN_IMMOBILE: RejectionStage.GEOMETRY,
    Rejection.ANSWER_UNREACHABLE: RejectionStage.GEOMETRY,
    Rejection.ANSWER_NOT_VISIBLE: RejectionStage.GEOMETRY,
    Rejection.CROWDED: RejectionStage.GEOMETRY,
    Rejection.OTHER_CHANGE_NEAR: RejectionStage.GEOMETRY,
    Rejection.CHANGED_INSTANCE_NOT_RECORDED: RejectionStage.OBSERVATION,
    Rejection.OTHER_CHANGE_NOT_RECORDED: RejectionStage.OBSERVATION,
    Rejection.MOTION_NOT_RECORDED: RejectionStage.OBSERVATION,
    Rejection.ABOVE_CHANCE: RejectionStage.OBSERVATION,
    Rejection.REFERENT_ABSENT: RejectionStage.OBSERVATION,
    Rejection.REFERENT_AMBIGUOUS: RejectionStage.OBSERVATION,
    Rejection.REFERENT_NOT_TARGET: RejectionStage.OBSERVATION,
    Rejection.BYSTANDER_MOVED: RejectionStage.OBSERVATION,
    Rejection.DRIFTED: RejectionStage.OBSERVATION,
    Rejection.FEASIBILITY_FAILED: RejectionStage.CERTIFICATION,
    Rejection.CERTIFICATION_FAILED: RejectionStage.CERTIFICATION,
    Rejection.SHARED_TOURS: RejectionStage.RELEASE,
    Rejection.SIMULATOR_ERROR: RejectionStage.SIMULATOR,
}
