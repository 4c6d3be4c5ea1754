"""The levels of isolation for tests: those that this machine lacks are skipped with the reason."""

from __future__ import annotations

import pytest

from ovman.remote.isolation import Isolation, unavailable

LEVELS = [
    pytest.param(level, marks=pytest.mark.skipif(unavailable(level) is not None, reason=str(unavailable(level))))
    for level in (Isolation.BUBBLEWRAP, Isolation.LANDLOCK)
]
