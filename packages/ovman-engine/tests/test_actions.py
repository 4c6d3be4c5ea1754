"""Actions, tested through the unmodified ai2thor Controller and the engine's own process."""

from __future__ import annotations

import os
import signal

import numpy as np
from ai2thor.server import DepthFormat


def act(controller, action, image=False, **arguments):
    return controller.step(action=action, renderImage=image, **arguments).metadata


def pose(metadata):
    agent = metadata["agent"]
    return (*(agent["position"][k] for k in "xyz"), agent["rotation"]["y"], agent["cameraHorizon"], agent["isStanding"])


def at(controller):
    return pose(controller.last_event.metadata)


def first(metadata, kind):
    return next(o for o in metadata["objects"] if o["objectType"] == kind)


# Movement


def test_a_blocked_move_says_by_what_and_leaves_the_agent_where_it_was(controller):
    for _ in range(60):
        before = at(controller)
        metadata = act(controller, "MoveAhead")
        if not metadata["lastActionSuccess"]:
            break
    assert metadata["errorMessage"].endswith(" is blocking Agent 0 from moving by (0.0000, 0.0000, 0.2500).")
    assert metadata["errorCode"] is None and at(controller) == before
    assert not act(controller, "MoveAhead", forceAction=True)["lastActionSuccess"] and at(controller) == before
    metadata = act(controller, "MoveAhead", moveMagnitude=100)
    assert metadata["errorMessage"].startswith("Scene bounds do not contain target position: (")


# Objects


def test_a_scene_without_objects(controller):
    """An empty scene can be walked, drawn and simulated."""
    metadata = act(controller, "Pass")
    everything, here = [o["objectId"] for o in metadata["objects"]], metadata["agent"]["position"]
    assert act(controller, "RemoveObjsFromScene", objectIds=everything)["objects"] == []
    for action, arguments in [
        ("RotateRight", {}),
        ("GetReachablePositions", {}),
        ("InitialRandomSpawn", {}),
        ("ToggleMapView", {}),
        ("ToggleMapView", {}),
        ("RandomizeMaterials", {}),
        ("GetShortestPathToPoint", here),
        ("AdvancePhysicsStep", {"allowAutoSimulation": True}),
    ]:
        metadata = act(controller, action, image=True, **arguments)
        assert metadata["lastActionSuccess"], (action, metadata["errorMessage"])
        assert metadata["objects"] == [] and metadata["isSceneAtRest"]
    assert controller.last_event.frame.std() > 1 and controller.last_event.instance_masks


def test_depth_in_the_units_that_the_client_asks_for(reset):
    """Depth in millimetres, and as a fraction of the range between the planes, comes from the same metres."""
    controller = reset("FloorPlan401", renderDepthImage=True)
    formats = {}
    for wanted in DepthFormat:
        controller.server.depth_format = wanted
        formats[wanted] = controller.step("Pass").depth_frame
    controller.server.depth_format = DepthFormat.Meters
    metres = formats[DepthFormat.Meters]
    assert metres.dtype == np.float32 and 0.1 <= metres.min() < metres.max() < 20
    assert np.allclose(formats[DepthFormat.Millimeters], metres * 1000, rtol=1e-5)
    assert np.allclose(formats[DepthFormat.Normalized], metres / 19.9, rtol=1e-5)


# The engine as a process


DROP = ["MoveAhead", "RotateRight", "MoveAhead", "LookDown", "MoveRight"]
REST = ["GetReachablePositions", "RotateLeft", "MoveBack", "Pass", "Pass", "Pass"]


def walk(controller):
    """Events of a walk on which an object is dropped."""
    events = [controller.reset("FloorPlan201")]
    vase = first(events[0].metadata, "Vase")
    above = {**vase["position"], "y": vase["position"]["y"] + 0.3}
    events.append(controller.step("TeleportObject", objectId=vase["objectId"], position=above, forceAction=True))
    return events + [controller.step(action) for action in DROP + REST]


def test_two_engines_at_once_show_the_same_and_fast_emit_changes_nothing(controller, start):
    """Events are equal to the byte, also if one engine sends them all in full and the other sends patches."""
    with start(scene="FloorPlan201", **{**controller.initialization_parameters, "fastActionEmit": False}) as other:
        assert other.unity_pid != controller.unity_pid
        for one, two in zip(walk(controller), walk(other), strict=True):
            for key in one.metadata.keys() - {"colors"}:
                assert one.metadata[key] == two.metadata[key], (one.metadata["lastAction"], key)
            assert (one.frame is None) == (two.frame is None)
            if one.frame is not None:
                assert np.array_equal(one.frame, two.frame) and np.array_equal(one.depth_frame, two.depth_frame)
                assert np.array_equal(one.instance_segmentation_frame, two.instance_segmentation_frame)


def test_an_interrupt_that_is_meant_for_the_client_does_not_end_the_engine(controller, alive):
    os.kill(controller.unity_pid, signal.SIGINT)
    assert act(controller, "Pass")["lastActionSuccess"] and alive(controller.unity_pid)
