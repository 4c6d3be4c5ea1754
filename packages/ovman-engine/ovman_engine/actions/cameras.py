"""Actions on third-party cameras and on the map view."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np

from ovman_engine.actions.registry import Thrown, action, out_of_range
from ovman_engine.actions.values import MAX_COMPONENT, PartialVector3, Vector3
from ovman_engine.client.resolution import objection
from ovman_engine.client.session import Session
from ovman_engine.picture.map_view import MapView
from ovman_engine.picture.third_party import ThirdPartyCamera, normal_angles
from ovman_engine.world.errors import Refused

MAX_ORTHOGRAPHIC_M = 1000.0
"""Largest half height of an orthographic image, metres."""
MAX_CAMERAS = 64
"""Largest number of third-party cameras: each one draws its images in every event."""
NAMED = {
    "red": "ff0000",
    "cyan": "00ffff",
    "blue": "0000ff",
    "darkblue": "0000a0",
    "lightblue": "add8e6",
    "purple": "800080",
    "yellow": "ffff00",
    "lime": "00ff00",
    "fuchsia": "ff00ff",
    "white": "ffffff",
    "silver": "c0c0c0",
    "grey": "808080",
    "black": "000000",
    "orange": "ffa500",
    "brown": "a52a2a",
    "maroon": "800000",
    "green": "008000",
    "olive": "808000",
    "navy": "000080",
    "teal": "008080",
    "aqua": "00ffff",
    "magenta": "ff00ff",
}
"""Unity's colour names."""


@action("AddThirdPartyCamera")
def add_third_party_camera(
    session: Session,
    position: Vector3,
    rotation: Vector3,
    fieldOfView: float = 90.0,
    skyboxColor: str | None = None,
    orthographic: bool = False,
    orthographicSize: float | None = None,
    nearClippingPlane: float | None = None,
    farClippingPlane: float | None = None,
    antiAliasing: str = "none",
) -> None:
    """AddThirdPartyCamera: every later event carries its images."""
    if len(session.cameras) >= MAX_CAMERAS:
        raise Refused(f"This engine has at most {MAX_CAMERAS} third-party cameras.")
    if problem := objection(session.width, session.height, 2 + len(session.cameras)):
        raise Refused(problem)
    settings = session.settings
    blank = ThirdPartyCamera((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), fieldOfView, settings.near_m, settings.far_m)
    camera = _changed(
        blank,
        position.array,
        rotation.array,
        fieldOfView,
        skyboxColor,
        orthographic,
        orthographicSize,
        nearClippingPlane,
        farClippingPlane,
    )
    session.cameras = (*session.cameras, camera)


@action("UpdateThirdPartyCamera")
def update_third_party_camera(
    session: Session,
    thirdPartyCameraId: int = 0,
    position: PartialVector3 | None = None,
    rotation: PartialVector3 | None = None,
    fieldOfView: float | None = None,
    skyboxColor: str | None = None,
    orthographic: bool | None = None,
    orthographicSize: float | None = None,
    nearClippingPlane: float | None = None,
    farClippingPlane: float | None = None,
) -> None:
    """UpdateThirdPartyCamera: changes the given properties of one camera."""
    cameras = session.cameras
    if fieldOfView is not None:
        _check_field_of_view(fieldOfView)
    if not 0 <= thirdPartyCameraId < len(cameras):
        raise out_of_range(
            f"thirdPartyCameraId: {thirdPartyCameraId} (int: default=0) must in "
            f"0 <= thirdPartyCameraId < len(thirdPartyCameras)={len(cameras)}."
        )
    old = cameras[thirdPartyCameraId]
    camera = _changed(
        old,
        np.array(old.position) if position is None else position.over(old.position),
        np.array(old.rotation) if rotation is None else rotation.over(old.rotation),
        old.field_of_view_deg if fieldOfView is None else fieldOfView,
        skyboxColor,
        orthographic,
        orthographicSize,
        nearClippingPlane,
        farClippingPlane,
    )
    session.cameras = (*cameras[:thirdPartyCameraId], camera, *cameras[thirdPartyCameraId + 1 :])


def _changed(
    camera: ThirdPartyCamera,
    position: np.ndarray,
    rotation: np.ndarray,
    fov: float,
    sky: str | None,
    orthographic: bool | None,
    size: float | None,
    near: float | None,
    far: float | None,
) -> ThirdPartyCamera:
    """`camera` with all arguments changed that are not None. Refused, without effect, if the result is not a valid camera."""
    _check_field_of_view(fov)
    if size is not None and not orthographic:
        raise Thrown(
            "InvalidOperationException",
            f"orthographicSize(: {size:g}) can only be set when orthographic=True.\n"
            "Otherwise, we use assume perspective camera setting."
            "Hint: call .step(..., orthographic=True).",
        )
    if size is not None and not 0 < size <= MAX_ORTHOGRAPHIC_M:
        raise out_of_range(f"orthographicSize: {size:g} must be in (0, {MAX_ORTHOGRAPHIC_M:g}].")
    near = camera.near_m if near is None else near
    far = camera.far_m if far is None else far
    if not 0 < near < far <= MAX_COMPONENT:
        raise out_of_range(
            f"nearClippingPlane: {near:g} and farClippingPlane: {far:g} must satisfy 0 < near < far <= {MAX_COMPONENT:g}."
        )
    x, y, z = position
    return replace(
        camera,
        position=(float(x), float(y), float(z)),
        rotation=normal_angles(rotation),
        field_of_view_deg=fov,
        near_m=near,
        far_m=far,
        orthographic=camera.orthographic if orthographic is None else orthographic,
        orthographic_m=camera.orthographic_m if size is None else size,
        sky=camera.sky if sky is None else _colour(sky),
    )


def _check_field_of_view(fov: float) -> None:
    if not 0 < fov < 180:
        raise out_of_range(f"fieldOfView: {fov:g} must be in 0 < fieldOfView < 180: fov is in (0, 180), noninclusive.")


def _colour(text: str) -> tuple[int, int, int] | None:
    """Return an sRGB colour from its name or from #RGB, #RGBA, #RRGGBB or #RRGGBBAA; None for "default"."""
    if text == "default":
        return None
    digits = NAMED.get(text.lower())
    if digits is None and re.fullmatch(r"#([0-9a-fA-F]{3,4}|[0-9a-fA-F]{6}|[0-9a-fA-F]{8})", text):
        digits = "".join(d * 2 for d in text[1:]) if len(text) <= 5 else text[1:]
    if digits is None:
        raise Thrown("ArgumentException", f"Invalid skyboxColor: {text}! Cannot be parsed as an HTML color.")
    red, green, blue = bytes.fromhex(digits)[:3]
    return red, green, blue


@action("ToggleMapView")
def toggle_map_view(session: Session) -> None:
    """ToggleMapView: replaces the agent's camera by an orthographic view from above, or restores it."""
    session.map_view = MapView.of(session.world) if session.map_view is None else None


@action("GetMapViewCameraProperties")
def map_view_camera_properties(session: Session) -> dict[str, Any]:
    """GetMapViewCameraProperties: the camera of the map view, as AI2-THOR describes it."""
    return MapView.of(session.world).properties()
