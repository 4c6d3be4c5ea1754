"""The task: relations (Eq. 1), admissibility (Eq. 2), answer (Eq. 3), success (Eq. 4), SPL (Eq. 5). Pure functions of records."""

from ovman.records.measurement import Measurement
from ovman.records.query import Query
from ovman.records.rejection import Rejection, RejectionStage
from ovman.records.relation import Relation
from ovman.records.world_state import Instance, WorldState, displacement_m
from ovman.task.admissibility import Inadmissible, admissible
from ovman.task.answer import answer
from ovman.task.crowding import category_pick, crowding
from ovman.task.referents import holds, referents
from ovman.task.success import spl, success, visible

__all__ = [
    "Inadmissible",
    "Instance",
    "Measurement",
    "Query",
    "Rejection",
    "RejectionStage",
    "Relation",
    "WorldState",
    "admissible",
    "answer",
    "category_pick",
    "crowding",
    "displacement_m",
    "holds",
    "referents",
    "spl",
    "success",
    "visible",
]
