"""JSON as the columns of the tables have it."""

from __future__ import annotations

import json
from typing import Any


def json_text(value: Any) -> str | None:
    """A JSON value as compact text, None for None. Its numbers are a record's, which are rounded."""
    return None if value is None else json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)
