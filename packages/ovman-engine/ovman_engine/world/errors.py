"""How a change of a world fails."""

from __future__ import annotations


class Refused(Exception):
    """An action failed. The message is AI2-THOR's."""


class Unsettled(Refused):
    """A placed object did not come to rest."""
