"""Returns free memory to the operating system."""

from __future__ import annotations

import contextlib
import ctypes
from functools import cache


@cache
def _trim():
    with contextlib.suppress(OSError, AttributeError):  # a C library other than GNU's
        return ctypes.CDLL(None).malloc_trim
    return lambda _pad: 0


def trim() -> None:
    """Return free memory of the allocator.

    Takes about a millisecond: call it after work that needed much more memory than what follows.
    """
    _trim()(0)
