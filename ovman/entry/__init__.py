"""Entries of somebody else's agent, outside the workflow: the score of its points, and its evaluation on episodes."""

from __future__ import annotations

from ovman.shipped import EMBEDDED, HOME

CONFIG, DATA, LEADERBOARD = HOME / "config.yaml", HOME / EMBEDDED, HOME / "leaderboard"
"""The settings, the release, and the entries of everybody, for commands that name no others."""


class EntryError(ValueError):
    """Something that was handed in cannot be judged; one line with place and remedy."""
