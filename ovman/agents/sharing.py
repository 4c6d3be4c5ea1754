"""Keep what an agent makes of its tours for the next query about them: the queries of a world pair follow each other."""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from functools import wraps
from typing import Any, TypeVar, cast

from ovman.agents.interface import Visit
from ovman.perception.records import Detected

KEPT = 2
"""Results that each function keeps: one per tour, or one per direction of a comparison."""

Make = TypeVar("Make", bound=Callable[..., Any])


def keep_last(make: Make) -> Make:
    """Return `make`, a pure function of positional arguments, with its last KEPT results kept.

    A visit or its detections are equal to others of the same content, all other arguments are compared as they are. Nothing is
    kept for a visit whose content is unknown. Callers share a result, so nobody may change it.
    """
    kept: OrderedDict[Hashable, Any] = OrderedDict()

    @wraps(make)
    def find(*given: Any) -> Any:
        key = tuple(one.content if isinstance(one, Visit | Detected) else one for one in given)
        if None in key:
            return make(*given)
        if key not in kept:
            while len(kept) >= KEPT:  # before the next one is made, so that no more are in memory
                kept.popitem(last=False)
            kept[key] = make(*given)
        kept.move_to_end(key)
        return kept[key]

    return cast(Make, find)
