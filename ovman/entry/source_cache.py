"""What one process of a command found in the code's files, for the next: a digest of all of them takes a second to find anew."""

from __future__ import annotations

from ovman.perception.libraries import cache
from ovman.workflow.provenance import remember

FILE = "sources.json"
"""In the folder of ovman in the user's cache. It is keyed by what the files contain, and may be deleted."""


def remembered() -> None:
    """Begin with what is known of the code's files, and keep what is new. To be called before a digest is asked for."""
    remember(cache() / FILE)
