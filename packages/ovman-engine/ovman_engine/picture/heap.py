"""Memory that the allocator keeps for later, given back."""

from __future__ import annotations

import contextlib
import ctypes
from functools import cache


@cache
def _trim():
    with contextlib.suppress(OSError, AttributeError):  # another C library than GNU's gives back what it will
        return ctypes.CDLL(None).malloc_trim
    return lambda _pad: 0


def trim() -> None:
    """Gives back what is free. Takes about a millisecond: for the end of work that needed much more than what comes after it."""
    _trim()(0)
