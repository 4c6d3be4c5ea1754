"""Contract, section 3: actions and arguments are matched by name, with AI2-THOR's codes and messages."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.scenes(1)


@pytest.mark.parametrize("action", ["LookUp", "LookDown", "RotateLook", "Initialize"])
def test_actions_of_the_old_style_take_anything(thor, action):
    thor.ok("Teleport", horizon=0)
    thor.ok(action, zzz=1, **({"rotation": 90, "horizon": 0} if action == "RotateLook" else {}))


def test_a_refused_action_changes_nothing(thor):
    before, objects = thor.pose, thor.objects
    for name, arguments in (
        ("Nothing", {}),
        ("MoveAhead", {"zzz": 1}),
        ("TeleportFull", {}),
        ("MoveAhead", {"moveMagnitude": []}),
    ):
        with pytest.raises(ValueError):
            thor.step(name, **arguments)
    assert thor.pose == before
    assert {k: v["position"] for k, v in thor.objects.items()} == {k: v["position"] for k, v in objects.items()}
