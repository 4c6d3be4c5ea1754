"""Actions that let time pass, and that pause physics."""

from __future__ import annotations

from ovman_engine.actions.registry import action
from ovman_engine.client.session import Session
from ovman_engine.world.errors import Refused

MAX_STEP_S = 0.05
MAX_S = 60.0
"""Longest simulated time of one action: the client is waiting."""


@action("Pass")
def pass_(session: Session) -> None:
    """Nothing but the time that every action takes."""


@action("Done")
def done(session: Session) -> None:
    """Nothing but the time that every action takes."""


@action("PausePhysicsAutoSim")
def pause(session: Session) -> None:
    """PausePhysicsAutoSim: physics runs only on AdvancePhysicsStep."""
    session.auto_simulation = False


@action("UnpausePhysicsAutoSim")
def unpause(session: Session) -> None:
    """UnpausePhysicsAutoSim: physics runs with every action."""
    session.auto_simulation = True


@action("AdvancePhysicsStep")
def advance(session: Session, timeStep: float = 0.02, simSeconds: float | None = None, allowAutoSimulation: bool = False) -> None:
    """AdvancePhysicsStep: lets physics run for `simSeconds`, or for one `timeStep`."""
    if session.auto_simulation and not allowAutoSimulation:
        raise Refused(
            "AdvancePhysicsStep can only be called if Physics AutoSimulation is currently paused or if you have passed"
            " allowAutoSimulation=true! Either use the PausePhysicsAutoSim() action first, or if you already used it, Physics"
            " AutoSimulation has been turned back on already."
        )
    if not 0 < timeStep <= MAX_STEP_S:
        raise Refused("Please use a timeStep between 0.0f and 0.05f. Larger timeSteps produce inconsistent simulation results.")
    seconds = timeStep if simSeconds is None else simSeconds
    if seconds < 0:
        raise Refused(f"simSeconds must be non-negative (simSeconds=={seconds:g}).")
    if seconds > MAX_S:
        raise Refused(f"simSeconds must be at most {MAX_S:g} (simSeconds=={seconds:g}).")
    session.world.advance(seconds)
