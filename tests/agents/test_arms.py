from __future__ import annotations

import subprocess
import sys

import pytest

from ovman.agents.arms import ARMS, Kind, Source, named, of_kind


def test_names_are_unique_and_serve_as_file_names():
    names = [arm.name for arm in ARMS]
    assert len(set(names)) == len(names)
    assert all(name.isidentifier() and name.islower() for name in names)


def test_rows_of_a_table_are_told_apart_by_what_the_table_shows():
    static = [(arm.system, arm.memory, arm.grounding, arm.positions) for arm in of_kind(Kind.STATIC)]
    embodied = [arm.system for arm in of_kind(Kind.EMBODIED)]
    assert len(set(static)) == len(static)
    assert len(set(embodied)) == len(embodied)


def test_an_embodied_arm_executes_the_static_arm_that_is_like_it():
    for arm in ARMS:
        if arm.executes is not None:
            assert arm.kind is Kind.EMBODIED
            followed = named(arm.executes)
            assert followed.kind is Kind.STATIC
            assert (followed.memory, followed.grounding, followed.positions) == (arm.memory, arm.grounding, arm.positions)


def test_positions_handed_over_leave_nothing_to_ground():
    assert all(arm.grounding is Source.HANDED for arm in ARMS if arm.positions is Source.HANDED)


def test_kinds_partition_the_arms():
    assert sorted(arm.name for kind in Kind for arm in of_kind(kind)) == sorted(arm.name for arm in ARMS)


def test_an_unknown_arm_is_answered_with_the_known_ones():
    with pytest.raises(KeyError, match="oracle_check"):
        named("oracle")


def test_the_table_is_read_without_anything_heavy():
    heavy = "numpy", "scipy", "pandas", "torch", "pydantic"
    script = f"import sys, ovman.agents.arms; print([name for name in {heavy} if name in sys.modules])"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
