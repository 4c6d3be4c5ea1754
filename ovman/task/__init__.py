"""What an episode is: relations (Eq. 1), admissibility (2), answer (3), success (4), SPL (5), and its record."""

from ovman.task.admissibility import Inadmissible, admissible
from ovman.task.answer import answer
from ovman.task.constants import TaskConstants
from ovman.task.referents import Query, holds, referents
from ovman.task.rejection import Rejection, RejectionStage
from ovman.task.relation import Relation
from ovman.task.success import Measurement, spl, success, visible
from ovman.task.world_state import Instance, Point, WorldState, displacement_m

__all__ = [
    "Inadmissible",
    "Instance",
    "Measurement",
    "Point",
    "Query",
    "Rejection",
    "RejectionStage",
    "Relation",
    "TaskConstants",
    "WorldState",
    "admissible",
    "answer",
    "displacement_m",
    "holds",
    "referents",
    "spl",
    "success",
    "visible",
]
