"""The engine's log, on standard error. The client appends it to a file that is never truncated."""

from __future__ import annotations

import contextlib
import os
import sys

ENTRY_BYTES = 8 << 10
"""Longest entry; a longer one loses its middle."""
LIMIT_BYTES = 256 << 10
"""Limit of one process: an action that fails in every step of a training run must not fill the disk."""
_ELLIPSIS = b"\n...\n"
_left = LIMIT_BYTES


def note(text: str) -> None:
    """Log `text`. Never raises: the engine serves on if its log is closed or on a full disk."""
    global _left
    if _left <= 0:
        return
    entry = (text.rstrip("\n") + "\n").encode("utf-8", "replace")
    if len(entry) > ENTRY_BYTES:
        half = (ENTRY_BYTES - len(_ELLIPSIS)) // 2
        entry = entry[:half] + _ELLIPSIS + entry[-half:]
    _left -= len(entry)
    if _left <= 0:
        entry += b"ovman-engine: the log of this process has reached its limit\n"
    with contextlib.suppress(OSError, ValueError, AttributeError):
        os.write(sys.stderr.fileno(), entry)
