"""What is made of a network is made once, and again where its file is not what was written."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from ovman.perception import network_cache
from ovman.perception.network_cache import NetworkCache


@pytest.fixture
def cache(tmp_path, monkeypatch) -> Path:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    return tmp_path / "ovman" / "networks"


class Maker:
    """Makes one content and counts how often."""

    def __init__(self, content: bytes) -> None:
        self.content, self.times = content, 0

    def __call__(self) -> bytes:
        self.times += 1
        return self.content


@pytest.mark.parametrize("content", [b"", b"a graph"])
def test_a_content_is_made_once(cache, content):
    make = Maker(content)
    assert [NetworkCache("a").content("x", make) for _ in range(3)] == [content] * 3 and make.times == 1
    assert NetworkCache("b").content("x", make) == NetworkCache("a").content("y", make) == content and make.times == 3
    assert sorted(path.relative_to(cache).as_posix() for path in cache.glob("*/*")) == ["a/x", "a/y", "b/x"]


@pytest.mark.parametrize(
    "spoil", [lambda b: b[:-1], lambda b: b[:10], lambda b: b"", lambda b: b[:-1] + b"?", lambda b: b + b"?"]
)
def test_a_file_that_is_torn_or_changed_is_made_again(cache, spoil):
    make = Maker(b"a graph")
    NetworkCache("a").content("x", make)
    path = cache / "a" / "x"
    whole = path.read_bytes()
    path.write_bytes(spoil(whole))
    assert NetworkCache("a").content("x", make) == b"a graph" and make.times == 2 and path.read_bytes() == whole


def test_a_network_without_a_name_has_nothing_kept(cache):
    make = Maker(b"a graph")
    assert [NetworkCache(None).content("x", make) for _ in range(2)] == [b"a graph"] * 2
    assert make.times == 2 and not cache.exists()


def test_where_nothing_can_be_written_all_goes_on(cache):
    cache.parent.parent.mkdir(exist_ok=True)
    cache.parent.write_text("no folder")
    assert NetworkCache("a").content("x", Maker(b"a graph")) == b"a graph"


def test_what_cannot_be_made_leaves_nothing_behind(cache):
    def fail() -> bytes:
        raise ValueError("no weights")

    with pytest.raises(ValueError, match="no weights"):
        NetworkCache("a").content("x", fail)
    assert not cache.exists()


def test_the_networks_that_were_used_longest_ago_are_forgotten(cache):
    names = [f"{n:02d}" for n in range(network_cache.AT_MOST)]
    for n, name in enumerate(names):
        NetworkCache(name).content("x", Maker(b"a graph"))
        os.utime(cache / name, (n, n))
    NetworkCache("00").content("x", Maker(b"a graph"))  # is used again
    NetworkCache("new").content("x", Maker(b"a graph"))
    assert sorted(path.name for path in cache.iterdir()) == sorted({*names, "new"} - {"01"})
