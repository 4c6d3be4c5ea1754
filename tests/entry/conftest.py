"""What the tests of evaluations have in common: recorded tours, and one evaluation that nothing disturbs."""

from __future__ import annotations

import pytest

from ovman.models.settings import MAIN
from tests.entry.evaluations import DEPTH, SCENE, command


@pytest.fixture(scope="session")
def tours(tmp_path_factory):
    """The folder of recorded tours."""
    return tmp_path_factory.mktemp("tours")


@pytest.fixture(scope="session")
def depth_driving(tmp_path_factory, tours):
    """The evaluation of a control on two episodes of main under two seeds."""
    out = tmp_path_factory.mktemp("evaluation") / "out"
    options = ["--arm", DEPTH, "--split", MAIN, "--scenes", SCENE, "--seeds", "0", "1"]
    assert command("eval", "--out", out, "--cache", tours, *options) == 0
    return out
