"""What is wrong with an entry, or with what it is judged by."""

from __future__ import annotations


class EntryError(ValueError):
    """What stands in the way of a score; the message is one line with the remedy."""
