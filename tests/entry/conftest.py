"""What the tests of evaluations have in common: evaluations that nothing disturbs."""

from __future__ import annotations

import pytest

from ovman.settings import MAIN
from tests.entry.evaluations import DEPTH, SCENE, command
from tests.shared import made_once


def driven(factory, tours, name, *seeds):
    """The evaluation of a control on two episodes of main under some seeds."""

    def make(out):
        options = ["--arm", DEPTH, "--split", MAIN, "--scenes", SCENE, "--seeds", *seeds]
        assert command("eval", "--out", out, "--cache", tours, *options) == 0

    return made_once(factory, name, make)


@pytest.fixture(scope="session")
def depth_driving(tmp_path_factory, tours):
    """Under two seeds. No test writes into it."""
    return driven(tmp_path_factory, tours, "depth_driving", 0, 1)


@pytest.fixture(scope="session")
def depth_first_seed(tmp_path_factory, tours):
    """Under the first seed alone. No test writes into it."""
    return driven(tmp_path_factory, tours, "depth_first_seed", 0)
