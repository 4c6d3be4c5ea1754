"""What an arm of ours is made with on the agent's side is what the workflow makes it with."""

from __future__ import annotations

import pytest

from ovman.remote import host
from ovman.remote.host import host_arm
from ovman.sim.embodiment import Embodiment
from tests.arms import BY_NAME, CONFIG


def begin(body):
    """The message `begin` for a body, as `ovman.remote.agent` writes it."""
    camera = {"width": body.width_px, "height": body.height_px, "field_of_view_deg": body.field_of_view_deg}
    words = {name: [1, 2, 3, 4] for name in ("picks", "paths")}
    return {**CONFIG.primitives.model_dump(mode="json"), "camera": camera, "words": words}


@pytest.mark.parametrize("name", ["cow", "two_visits_embodied"])
def test_section_camera_is_that_of_the_tours_whatever_body_an_arm_has(name, monkeypatch):
    # CoW's smallest mask is a share of the tours' frame; by its body's camera it was larger here than in the workflow.
    made = []
    monkeypatch.setattr(host, "load_agent", lambda *_: lambda context: made.append(context))
    body = Embodiment.named(BY_NAME[name].embodiment, CONFIG)
    host_arm(CONFIG, name)(begin(body))
    (context,) = made
    assert dict(context.settings.camera) == dict(CONFIG.camera)
    assert (body.width_px == CONFIG.camera.width_px) == (name != "cow")
