"""Homes from a seed: the same bytes everywhere, ProcTHOR's schema, sound rooms, and a check that finds faults."""

from __future__ import annotations

import copy
import hashlib
import json
import os
import random
import subprocess
import sys
from collections import defaultdict
from pathlib import Path
from typing import Any, get_type_hints

import numpy as np
import pytest
from procthor.utils import types as procthor_types

import ovman.homes
from ovman.homes.catalogue import SPLITS, Asset, assets, categories, database, groups, looks_different
from ovman.homes.check import check
from ovman.homes.generate import draw, generate
from ovman.homes.stream import Stream

TWELVE = [(seed, rooms, split) for seed in (1, 2) for rooms in (1, 2, 3) for split in ("test", "train")]
LOOKS = Path(ovman.homes.__file__).with_name("looks.json")
DIGESTS = {
    "1 1 test": "b55e29a1663c",
    "1 1 train": "1c73e9fb7d70",
    "1 2 test": "68e236425b18",
    "1 2 train": "861640264cec",
    "1 3 test": "307a3433e88b",
    "1 3 train": "262bc6f3b8e3",
    "2 1 test": "955c711c5815",
    "2 1 train": "b2c63c66623f",
    "2 2 test": "1cca28b32034",
    "2 2 train": "22d73316d751",
    "2 3 test": "b39aef7ac157",
    "2 3 train": "3fe901d03e7b",
}
"""First digits of the digests of twelve homes. They change with the generator, never with the machine."""


def digest(house: Any) -> str:
    return hashlib.sha256(json.dumps(house, sort_keys=True).encode()).hexdigest()[:12]


@pytest.fixture(scope="module")
def homes():
    """Homes of one, two and three rooms."""
    return [draw(f"40.{rooms}", rooms, "test") for rooms in (1, 2, 3)]


@pytest.fixture(scope="module")
def by_id():
    return {a.id: a for split in SPLITS for category in categories() for a in assets(category, split)}


def walk(objects, parent=None):
    for thing in objects:
        yield thing, parent
        yield from walk(thing["children"], thing)


def test_a_seed_gives_the_same_bytes_in_every_process_and_order():
    """In another process, with another hash seed and in another order, and they are those of twelve frozen homes."""
    here = {f"{seed} {rooms} {split}": digest(generate(seed, rooms, split)) for seed, rooms, split in TWELVE}
    code = (
        "import sys; from tests.homes.test_homes import TWELVE, digest; from ovman.homes.generate import generate;"
        "[print(*home, digest(generate(*home))) for home in reversed(TWELVE)]"
    )
    said = subprocess.run(
        [sys.executable, "-c", code], env=os.environ | {"PYTHONHASHSEED": "7"}, text=True, capture_output=True, check=True
    )
    there = {" ".join(line.split()[:3]): line.split()[3] for line in said.stdout.splitlines()}
    assert here == there
    assert here == DIGESTS


def test_other_arguments_give_other_homes():
    found = [
        generate(*arguments) for arguments in ((1, 1, "test"), (2, 1, "test"), (1, 2, "test"), (1, 1, "val"), (1, 1, "test", 3))
    ]
    assert len({digest(house) for house in found}) == len(found)


def test_draws_of_a_stream_follow_the_promised_generator():
    """A stream is Python's `random.random` of the digest of its names; draws are fair."""
    stream = Stream("a", 1)
    seed = int.from_bytes(hashlib.sha256(b"a|1").digest(), "big")
    reference = random.Random(seed)
    assert [stream.integer(0, 999) for _ in range(5)] == [int(1000 * reference.random()) for _ in range(5)]
    counts = np.bincount([Stream("b", k).choice([0, 1, 2], [1.0, 2.0, 1.0]) for k in range(800)])
    assert np.abs(counts - [200, 400, 200]).max() < 60
    assert sorted(Stream("c").shuffled(range(9))) == list(range(9))
    assert {Stream("d", k).integer(5, 17, 5) for k in range(60)} == {5, 10, 15}


def test_homes_have_the_keys_and_types_of_procthor(homes):
    """Each record has the keys that ProcTHOR's types require; kinds of rooms and ids of walls are ProcTHOR's."""
    required = {
        name: set(get_type_hints(getattr(procthor_types, name))) for name in ("Door", "Window", "Object", "RoomType", "Wall")
    }
    for house in (home.house for home in homes):
        assert set(house) == set(get_type_hints(procthor_types.HouseDict)) | {"metadata"}
        for key, name in {"doors": "Door", "windows": "Window", "rooms": "RoomType", "walls": "Wall"}.items():
            for record in house[key]:
                assert set(record) >= required[name] - {"empty"}, key
        assert all(set(thing) >= required["Object"] for thing, _ in walk(house["objects"]))
        walls = {wall["id"] for wall in house["walls"]}
        for opening in (*house["doors"], *house["windows"]):
            assert {opening["wall0"], opening["wall1"]} <= walls
        assert {room["roomType"] for room in house["rooms"]} <= {"Kitchen", "LivingRoom", "Bedroom"}
        assert house["proceduralParameters"]["skyboxId"] in database("skyboxes.json")


def test_homes_are_sound_and_of_the_wanted_size(homes):
    for rooms, home in enumerate(homes, start=1):
        assert home.report.ok and check(home.house) == home.report
        assert len(home.house["rooms"]) == rooms == len(home.report.areas_m2)
        assert all(14.9 <= area <= 45 for area in home.report.areas_m2.values())
        assert home.report.woken > 20 and home.report.moved_m <= 0.02


def test_assets_of_splits_never_mix(by_id):
    """An asset without a split belongs to train."""
    entries = {e["assetId"]: e["split"] or "train" for found in database("asset-database.json").values() for e in found}
    for split in SPLITS:
        house = generate(5, 2, split)
        used = [thing["assetId"] for thing, _ in walk(house["objects"])]
        used += [opening["assetId"] for opening in (*house["doors"], *house["windows"])]
        assert len(used) > 30 and {entries[name] for name in used} == {split}


def test_abundant_categories_have_instances_that_look_different(homes, by_id):
    for home in homes:
        loose: dict[str, list[Asset]] = defaultdict(list)
        for thing, _ in walk(home.house["objects"]):
            if by_id[thing["assetId"]].loose:
                loose[by_id[thing["assetId"]].category].append(by_id[thing["assetId"]])
        several = [c for c, found in loose.items() if any(looks_different(a.id, b.id) for a in found for b in found)]
        assert len(several) >= 5


def test_looks_are_symmetric_and_known_for_existing_assets(by_id):
    table = json.loads(LOOKS.read_text())
    for category, pairs in table.items():
        for first, second in pairs:
            assert by_id[first].category == by_id[second].category == category
            assert not looks_different(first, second) and not looks_different(second, first)
    assert looks_different("Chair_007_1", "Chair_002_1") and not looks_different("Chair_007_1", "Chair_007_1")


def test_groups_are_procthors():
    """A sofa faces its television; chairs stand on all sides of a table and face it."""
    table = next(g for g in groups() if g.name == "chair-diningtable-4")
    facing = {(part.side, part.yaw_deg) for part in table.parts if part.category == "Chair"}
    assert facing == {((0, -1), 0), ((0, 1), 180), ((-1, 0), 90), ((1, 0), 270)}
    for group in groups():
        assert group.parts[0].parent is None and all(part.parent < k for k, part in enumerate(group.parts) if k)


def shifted(house, name, **metres):
    """Return a copy of a house in which a thing is moved."""
    out = copy.deepcopy(house)
    thing = next(thing for thing, _ in walk(out["objects"]) if thing["id"] == name)
    for axis, value in metres.items():
        thing["position"][axis] += value
    return out


def test_check_finds_what_is_wrong(homes, by_id):
    """Things in each other, in the air, at the start and in the only way."""
    house = homes[1].house
    loose = next(t for t, parent in walk(house["objects"]) if parent is None and by_id[t["assetId"]].loose and not t["children"])
    other = next(t for t, parent in walk(house["objects"]) if parent is None and t["children"])
    name = loose["id"]

    def faults(**metres):
        return " ".join(check(shifted(house, name, **metres)).faults)

    def offset(to):
        return {axis: to[axis] - loose["position"][axis] for axis in "xz"}

    assert f"{name} overlaps" in faults(**offset(other["position"])) or f"overlaps {name}" in faults(**offset(other["position"]))
    assert f"{name} moves" in faults(y=0.5)
    assert f"{name} stands at the start" in faults(**offset(house["metadata"]["agent"]["position"]))
    walled = copy.deepcopy(house)
    walled["doors"] = [door for door in house["doors"] if door["room0"] == door["room1"]]
    assert any("is not reached" in fault for fault in check(walled).faults)


def test_unknown_rooms_and_assets_are_refused():
    with pytest.raises(ValueError, match="not 4 and 'test'"):
        generate(1, 4, "test")
    with pytest.raises(ValueError, match="not 1 and 'all'"):
        generate(1, 1, "all")
