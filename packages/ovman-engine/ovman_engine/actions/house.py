"""CreateHouse: a ProcTHOR house in the scene "Procedural"."""

from __future__ import annotations

from typing import Any

from ovman_engine.actions.registry import action
from ovman_engine.client.session import PROCEDURAL, Session
from ovman_engine.world.world import Refused


@action("CreateHouse")
def create_house(session: Session, house: Any) -> None:
    """Contract, section 4. The agent is put where the house says; if it says nothing, where most room is."""
    from ovman_engine.plan.blueprint import Malformed, read
    from ovman_engine.plan.houseplan import plan_of

    if session.scene_name != PROCEDURAL:
        raise Refused(f"CreateHouse can only be called in the scene {PROCEDURAL}, not in {session.scene_name or 'none'}.")
    try:
        made = read(house)
    except Malformed as error:
        raise Refused(f"House could not be created: {error}.") from None
    session.furnish(plan_of(made))
    if made.agent is not None:
        agent = session.world.agent
        _, agent.yaw_deg, agent.horizon_deg, agent.standing = made.agent
