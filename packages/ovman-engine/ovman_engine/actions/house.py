"""CreateHouse: puts a ProcTHOR house into the scene "Procedural"."""

from __future__ import annotations

from typing import Any

from ovman_engine.actions.registry import action
from ovman_engine.client.session import PROCEDURAL, Session
from ovman_engine.world.errors import Refused


@action("CreateHouse")
def create_house(session: Session, house: Any) -> None:
    """CreateHouse (contract, section 4).

    The agent starts where the house says, else at the point farthest from walls and objects.

    Refused, with the scene unchanged, if `house` is not a valid house.
    """
    from ovman_engine.plan.house_json import InvalidHouse, read
    from ovman_engine.plan.houseplan import plan_of

    if session.scene_name != PROCEDURAL:
        raise Refused(f"CreateHouse can only be called in the scene {PROCEDURAL}, not in {session.scene_name or 'none'}.")
    try:
        made = read(house)
    except InvalidHouse as error:
        raise Refused(f"House could not be created: {error}.") from None
    session.furnish(plan_of(made))
    if made.agent is not None:
        agent = session.world.agent
        _, agent.yaw_deg, agent.horizon_deg, agent.standing = made.agent
