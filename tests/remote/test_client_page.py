"""The example of the client's page does what the page says, with actions that the server takes."""

from __future__ import annotations

import re
from pathlib import Path
from types import SimpleNamespace

from ovman_client import Action
from ovman_client.messages import generator

PAGE = Path(__file__).parents[2] / "packages" / "ovman-client" / "README.md"


def test_the_example_drives_at_random_and_stops_after_twenty_actions():
    (example,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    names = {}
    exec(compile(example, str(PAGE), "exec"), names)
    agent = names["Agent"](SimpleNamespace(rng=generator([1, 2, 3, 4])))
    for hear in (agent.familiarise, agent.revisit, agent.ask):
        hear(None)
    actions = [agent.act(None) for _ in range(21)]
    assert all(isinstance(action, Action) for action in actions)
    assert actions[-1] is Action.STOP and {*actions[:20]} == {Action.MOVE_AHEAD, Action.ROTATE_LEFT, Action.ROTATE_RIGHT}
