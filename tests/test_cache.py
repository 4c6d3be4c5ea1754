"""The cache of finished work items."""

from __future__ import annotations

from pathlib import Path

import pytest

from ovman.cache import Cache, digest


def test_an_item_is_computed_once(tmp_path: Path) -> None:
    cache, calls = Cache(tmp_path), []

    def compute() -> dict[str, int]:
        calls.append(1)
        return {"a": 1}

    assert cache.get_or_compute(digest("x", 1), compute) == {"a": 1}
    assert Cache(tmp_path).get_or_compute(digest("x", 1), compute) == {"a": 1}
    assert len(calls) == 1


def test_a_failed_item_leaves_nothing(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError):
        Cache(tmp_path).get_or_compute(digest("x"), lambda: 1 // 0)
    assert not [path for path in tmp_path.rglob("*") if path.is_file()]


def test_a_damaged_item_is_computed_again(tmp_path: Path) -> None:
    cache, key = Cache(tmp_path), digest("x")
    cache.get_or_compute(key, lambda: [1, 2])
    cache.path(key).write_bytes(b"[1,")
    assert cache.get_or_compute(key, lambda: [3]) == [3]
    assert cache.get_or_compute(key, lambda: [4]) == [3]


def test_a_digest_depends_on_values_and_not_on_the_order_of_keys() -> None:
    assert digest({"a": 1, "b": 2}) == digest({"b": 2, "a": 1})
    assert digest({"a": 1, "b": 2}) != digest({"a": 2, "b": 1})
