"""The interface of an agent: what it is given and what it gives back.

The evaluator keeps the truth: an agent gets observations and the query, and no episode, answer or identity of an instance across
visits.
"""

from ovman.agents.interface.agent import Agent
from ovman.agents.interface.context import AgentContext, Mapper, PredictionContext, PrivilegedAnswer
from ovman.agents.interface.observation import LETTERS, VISITS, Action, CameraPose, Observation, SeenInstance, Visit
from ovman.records.prediction import Abstention, AbstentionReason, Answer, Evidence, Predicted, UniformBox, UniformPick
from ovman.records.query import Query
from ovman.records.relation import Relation

__all__ = [
    "LETTERS",
    "VISITS",
    "Abstention",
    "AbstentionReason",
    "Action",
    "Agent",
    "AgentContext",
    "Answer",
    "CameraPose",
    "Evidence",
    "Mapper",
    "Observation",
    "Predicted",
    "PredictionContext",
    "PrivilegedAnswer",
    "Query",
    "Relation",
    "SeenInstance",
    "UniformBox",
    "UniformPick",
    "Visit",
]
