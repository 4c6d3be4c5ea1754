"""Visibility: near objects in the image, not through others, and through glass without interaction."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from ovman_engine.picture.camera import Renderer
from ovman_engine.sight import visibility
from ovman_engine.sight.sightlines import TRANSPARENT
from ovman_engine.sight.visibility import Eye

SCENES = ("FloorPlan8", "FloorPlan206")
NEAR_M = 1.5
LARGE_PX = 50
"""An object with this many pixels of 90,000 must not be missed."""
FINER = 8
"""A visible object may be thinner than a pixel; a picture this many times finer then shows it."""


def poses(scene, count, seed=0):
    """Poses all over a scene, as arguments of TeleportFull."""
    rng = np.random.default_rng(seed)
    cells = scene.do("GetReachablePositions")["actionReturn"]
    for _ in range(count):
        yield {
            "position": cells[rng.integers(len(cells))],
            "rotation": {"x": 0, "y": float(30 * rng.integers(12)), "z": 0},
            "horizon": float(rng.choice([-30, 0, 30, 60])),
            "standing": bool(rng.integers(2)),
        }


def seen(metadata, key="visible"):
    return {o["objectId"] for o in metadata["objects"] if o[key]}


def shown(renderer, session, finer=1):
    """objectId -> pixels, and the distance in plan of the nearest of them from the agent, metres."""
    view = session.view()
    view = replace(view, width=finer * view.width, height=finer * view.height)
    frame = renderer.frame(view, rgb=False, depth=True, ids=True)
    across = (np.arange(view.width) + 0.5) / view.width * 2 - 1
    x, y = np.meshgrid(across, -across)
    ways = np.stack([x, y, np.ones_like(x)], axis=-1) @ view.axes()
    away = np.hypot(*np.moveaxis((ways * frame.depth[..., None])[..., [0, 2]], -1, 0))
    pixels = {renderer.names[i]: n for i, n in Counter(frame.ids.ravel().tolist()).items() if i >= 0}
    nearest = np.full(len(renderer.names), np.inf)
    np.minimum.at(nearest, frame.ids[frame.ids >= 0], away[frame.ids >= 0])
    return pixels, dict(zip(renderer.names, nearest.tolist(), strict=True))


def test_what_is_visible_is_in_the_picture_and_what_is_large_and_near_in_it_is_visible(engine):
    large = missed = 0
    for name in SCENES:
        scene = engine(name, fastActionEmit=False)
        renderer = Renderer(scene.engine.session.world)
        for pose in poses(scene, 8):
            metadata = scene.do("TeleportFull", **pose)
            assert metadata["lastActionSuccess"], metadata["errorMessage"]
            pixels, nearest = shown(renderer, scene.engine.session)
            if any(o["visible"] and not pixels.get(o["objectId"]) for o in metadata["objects"]):
                pixels = shown(renderer, scene.engine.session, FINER)[0] | pixels
            glazed = any(o["objectType"] in TRANSPARENT and pixels.get(o["objectId"]) for o in metadata["objects"])
            for record in metadata["objects"]:
                count = pixels.get(record["objectId"], 0)
                assert count or not record["isInteractable"], record["objectId"]
                assert count or glazed or not record["visible"], record["objectId"]
                if count > LARGE_PX and nearest[record["objectId"]] <= NEAR_M - 0.01:
                    large += 1
                    missed += not record["visible"]
    assert large > 50 and missed <= 0.01 * large


def test_from_farther_sight_more_is_visible_and_never_what_is_behind(engine):
    near, far = engine("FloorPlan8", visibilityDistance=1.0), engine("FloorPlan8", visibilityDistance=4.0)
    for pose in poses(near, 6, seed=1):
        close, wide = near.do("TeleportFull", **pose), far.do("TeleportFull", **pose)
        assert seen(close) <= seen(wide) and seen(close, "isInteractable") <= seen(close)
        yaw = np.radians(pose["rotation"]["y"])
        ahead = np.array([np.sin(yaw), np.cos(yaw)])
        here = np.array([close["agent"]["position"][k] for k in "xz"])
        for record in wide["objects"]:
            if record["visible"] and pose["horizon"] == 0:
                assert ((np.array(record["axisAlignedBoundingBox"]["cornerPoints"])[:, [0, 2]] - here) @ ahead).max() > 0


def test_the_schemes_differ_in_what_is_near_alone(engine):
    """From afar both schemes agree; near by, a visible object is that near, in plan."""
    collider, distance = (engine("FloorPlan315", visibilityDistance=50.0, visibilityScheme=s) for s in ("Collider", "Distance"))
    for pose in poses(collider, 4):
        assert seen(collider.do("TeleportFull", **pose)) == seen(distance.do("TeleportFull", **pose))
    collider, distance = (engine("FloorPlan315", visibilityScheme=s) for s in ("Collider", "distance"))
    for scene, pose in product((collider, distance), [*poses(collider, 6)]):
        metadata = scene.do("TeleportFull", **pose)
        here = np.array([metadata["agent"]["position"][k] for k in "xz"])
        for record in metadata["objects"]:
            if record["visible"]:
                box = np.array(record["axisAlignedBoundingBox"]["cornerPoints"])[:, [0, 2]]
                gap = np.maximum(np.maximum(box.min(axis=0) - here, here - box.max(axis=0)), 0)
                assert np.hypot(*gap) <= NEAR_M + 0.01, record["objectId"]


def put(scene, object_id, point):
    position = dict(zip("xyz", map(float, point), strict=True))
    metadata = scene.do("TeleportObject", objectId=object_id, position=position, forceAction=True, forceKinematic=True)
    assert metadata["lastActionSuccess"], metadata["errorMessage"]


def before_the_camera(scene, metres):
    view = scene.engine.session.view()
    return view.position + metres * view.axes()[2]


def test_hidden_by_what_stands_in_the_way_until_it_goes(engine):
    scene = engine("FloorPlan206", fastActionEmit=False)
    scene.do("PausePhysicsAutoSim")
    pillow = next(o for o in scene.agent["objects"] if o["objectType"] in ("Pillow", "Laptop", "Box"))["objectId"]
    small = next(o for o in scene.agent["objects"] if o["objectType"] in ("RemoteControl", "CreditCard", "KeyChain"))["objectId"]
    put(scene, small, before_the_camera(scene, 0.9))
    assert scene.object(small)["visible"] and scene.object(small)["isInteractable"]
    put(scene, pillow, before_the_camera(scene, 0.5))
    assert not scene.object(small)["visible"] and scene.object(pillow)["visible"]
    scene.do("DisableObject", objectId=pillow)
    assert scene.object(small)["visible"] and not scene.object(pillow)["visible"]
    scene.do("EnableObject", objectId=pillow)
    assert not scene.object(small)["visible"]
    scene.do("RemoveFromScene", objectId=pillow)
    assert scene.object(small)["visible"]


def test_what_is_behind_glass_is_seen_but_cannot_be_reached(engine):
    scene = engine("FloorPlan418", fastActionEmit=False, visibilityDistance=3.0)
    scene.do("PausePhysicsAutoSim")
    panes = [o["objectId"] for o in scene.agent["objects"] if o["objectType"] in ("ShowerGlass", "ShowerDoor")]
    soap = next(o for o in scene.agent["objects"] if o["objectType"] in ("SoapBar", "ToiletPaper", "SprayBottle"))["objectId"]
    for pane in panes:
        for pose in scene.do("GetInteractablePoses", objectId=pane, horizons=[0], standings=[True])["actionReturn"][::5]:
            scene.do("TeleportFull", **{**pose, "rotation": {"y": pose["rotation"]}})
            instance, metres, _ = met(scene)
            if instance == pane and 0.3 < metres < 2:
                put(scene, soap, before_the_camera(scene, metres + 0.25))
                record = scene.object(soap)
                assert record["visible"] and not record["isInteractable"]
                for other in panes:
                    scene.do("DisableObject", objectId=other)
                assert scene.object(soap)["isInteractable"]
                return
    pytest.fail("no place looks straight at a pane")


def met(scene):
    """The first instance on the ray through the middle of the image, its distance, and what is behind it."""
    sight, view = scene.engine.session.sight, scene.engine.session.view()
    looks = sight.look(view.position, view.axes()[2:])
    first, behind = ("" if i < 0 else sight.lines.names[i] for i in (looks.first[0], looks.behind[0]))
    return first, float(looks.away_m[0][0]), behind


def test_rays_that_are_left_out_would_find_no_object(engine, monkeypatch):
    for name in SCENES:
        scene = engine(name, fastActionEmit=False)
        world, sight = scene.engine.session.world, scene.engine.session.sight
        for pose in poses(scene, 12, seed=1):
            scene.do("TeleportFull", **pose, forceAction=True)
            eye = Eye.of(world.agent, 90.0, 1.0)
            found = sight.visible(eye, NEAR_M)
            with monkeypatch.context() as every:
                every.setattr(visibility, "ROUGHLY", 1)
                assert [one & world.bodies.keys() for one in sight.visible(eye, NEAR_M)] == [
                    one & world.bodies.keys() for one in found
                ]
