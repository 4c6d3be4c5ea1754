"""What an episode is: relations (Eq. 1), admissibility (2), answer (3), success (4), SPL (5), and its record."""

from ovman.task.admissibility import Inadmissible, admissible
from ovman.task.answer import answer
from ovman.task.certification import CertificationRun
from ovman.task.change import Change
from ovman.task.episode import Episode, episode_lines, read_episodes
from ovman.task.pose import Position, Spawn
from ovman.task.record import RecordError, line, records, rounded
from ovman.task.referents import Query, holds, referents
from ovman.task.rejection import Rejection, RejectionStage
from ovman.task.relation import Relation
from ovman.task.success import Measurement, spl, success, visible
from ovman.task.world_state import Instance, Point, WorldState, displacement_m

__all__ = [
    "CertificationRun",
    "Change",
    "Episode",
    "Inadmissible",
    "Instance",
    "Measurement",
    "Point",
    "Position",
    "Query",
    "RecordError",
    "Rejection",
    "RejectionStage",
    "Relation",
    "Spawn",
    "WorldState",
    "admissible",
    "answer",
    "displacement_m",
    "episode_lines",
    "holds",
    "line",
    "read_episodes",
    "records",
    "referents",
    "rounded",
    "spl",
    "success",
    "visible",
]
