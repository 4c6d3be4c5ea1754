"""CreateHouse: puts a ProcTHOR house into the scene "Procedural"."""

from __future__ import annotations

import json
from functools import lru_cache
from typing import TYPE_CHECKING, Any

from ovman_engine.actions.registry import action
from ovman_engine.client.session import PROCEDURAL, SCENES_KEPT, Session
from ovman_engine.world.errors import Refused

if TYPE_CHECKING:
    from ovman_engine.plan.floorplan import FloorPlan


@action("CreateHouse")
def create_house(session: Session, house: Any) -> None:
    """CreateHouse (contract, section 4).

    The agent starts where the house says, else at the point farthest from walls and objects.

    Refused, with the scene unchanged, if `house` is not a valid house.
    """
    from ovman_engine.plan.house_json import InvalidHouse

    if session.scene_name != PROCEDURAL:
        raise Refused(f"CreateHouse can only be called in the scene {PROCEDURAL}, not in {session.scene_name or 'none'}.")
    try:
        plan = _plan(json.dumps(house))
    except InvalidHouse as error:
        raise Refused(f"House could not be created: {error}.") from None
    session.furnish(plan)
    assert plan.house is not None
    if plan.house.agent is not None:
        agent = session.world.agent
        _, agent.yaw_deg, agent.horizon_deg, agent.standing = plan.house.agent


@lru_cache(maxsize=SCENES_KEPT)
def _plan(text: str) -> FloorPlan:
    """Return the floor plan of a house in JSON. The last few are kept: what is drawn of a plan is kept with it."""
    from ovman_engine.plan.house_json import read
    from ovman_engine.plan.houseplan import plan_of

    return plan_of(read(json.loads(text)))
