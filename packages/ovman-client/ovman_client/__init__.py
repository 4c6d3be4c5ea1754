"""The agent's side of OVMAN's protocol (docs/protocol.md of the repository): what an agent is given, and a server for it."""

from ovman_client.interface import Action, Camera, CameraPose, Context, Instruction, Observation, Query, Visit
from ovman_client.messages import PROTOCOL, MessageError
from ovman_client.server import Server, serve

__version__ = "0.7.0"
__all__ = [
    "PROTOCOL",
    "Action",
    "Camera",
    "CameraPose",
    "Context",
    "Instruction",
    "MessageError",
    "Observation",
    "Query",
    "Server",
    "Visit",
    "serve",
]
