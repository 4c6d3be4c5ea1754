"""The table of assets that look alike is the one that training/looks.py makes from the engine's pictures."""

from __future__ import annotations

import json
from itertools import combinations

import pytest

from training.looks import TABLE, look_alike, portray


@pytest.mark.parametrize("category", ["Dresser", "Stool", "Vase"])
def test_table_is_made_from_portraits(category):
    pairs = [pair for _, pool in portray(category) for pair in combinations(pool, 2)]
    assert [[a.asset.id, b.asset.id] for a, b in pairs if look_alike(a, b)] == json.loads(TABLE.read_text()).get(category, [])
