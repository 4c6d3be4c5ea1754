"""The room of any floor plan."""

from __future__ import annotations

from ovman_engine.plan.floorplan import FloorPlan
from ovman_engine.room.dwelling import Dwelling
from ovman_engine.room.inferred import InferredRoom
from ovman_engine.room.room import Room


def room_of(plan: FloorPlan) -> Room:
    """Return the room of `plan`: as given for a house, inferred for an iTHOR floor plan."""
    return InferredRoom.of(plan) if plan.house is None else Dwelling.of(plan)
