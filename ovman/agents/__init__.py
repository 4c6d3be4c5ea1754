"""Agents: the interface, the reference agent's parts, and the table of arms."""

from ovman.agents.interface import Action, Agent, CameraPose, Observation, Sighting, Visit

__all__ = ["Action", "Agent", "CameraPose", "Observation", "Sighting", "Visit"]
