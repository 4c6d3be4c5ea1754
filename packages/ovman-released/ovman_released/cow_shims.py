"""What is laid over CoW's released modules in their own process, so that they run with present libraries and on an OVMAN episode.

None of it touches the policy: names that libraries have dropped since, how a simulator is started, and an assertion that a target
is there. Nothing of the clone is written to.
"""

from __future__ import annotations

import inspect
import sys
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from types import ModuleType
from typing import Any

OWL_LOST = "transformers.models.owlvit.feature_extraction_owlvit"
OWL_KEPT = "transformers.image_transforms"
CORNERS = "center_to_corners_format"
DETECTOR, GRID = "MyOwlViTForObjectDetection", "normalize_grid_corner_coordinates"
GETTERS = ("get_object_by_id", "get_object_by_type")


def stand_in_for_lost_modules() -> None:
    """Before the released modules are imported: names that they import and that later releases have moved or dropped.

    setuptools no longer brings pkg_resources, of which `packaging` is used; transformers has its box conversion elsewhere.
    A module that is there is left alone.
    """
    if not _there("pkg_resources", "packaging"):
        stub = ModuleType("pkg_resources")
        import_module("packaging.version")
        stub.packaging = import_module("packaging")  # type: ignore[attr-defined]
        sys.modules["pkg_resources"] = stub
    if not _there(OWL_LOST, CORNERS):
        stub = ModuleType(OWL_LOST)
        setattr(stub, CORNERS, getattr(import_module(OWL_KEPT), CORNERS))
        sys.modules[OWL_LOST] = stub


def _there(module: str, name: str) -> bool:
    try:
        return hasattr(import_module(module), name)
    except ImportError:
        return False


def drop_outgrown_override(localization: ModuleType) -> None:
    """The released OWL-ViT overrides a method that its parent now calls with other arguments; the parent's does the same."""
    detector = getattr(localization, DETECTOR)
    own = vars(detector).get(GRID)
    parent = next((vars(base)[GRID] for base in detector.__mro__[1:] if GRID in vars(base)), None)
    if own is not None and parent is not None and _parameters(own) != _parameters(parent):
        delattr(detector, GRID)


def _parameters(member: Any) -> int:
    """How many arguments a call on an instance takes."""
    if isinstance(member, staticmethod):
        return len(inspect.signature(member.__func__).parameters)
    return len(inspect.signature(member).parameters) - 1


def start_no_display(runner: ModuleType) -> None:
    """S1: the runner would start an X server where there is no DISPLAY, which neither backend needs."""
    runner.RobothorChallenge.setup_env = staticmethod(lambda *_, **__: None)


def start_with(runner: ModuleType, controller: Callable[..., Any]) -> None:
    """S3: what the runner starts is made by `controller`. The client's own code, too, looks its class up by this name."""
    original = runner.ai2thor.controller.Controller

    class Controller(original):  # type: ignore[misc, valid-type]
        def __new__(cls, *arguments: Any, **parameters: Any) -> Any:
            return controller(*arguments, **parameters)

    runner.ai2thor.controller.Controller = Controller


def allow_absent_targets(runner: ModuleType) -> None:
    """S4: a target that is not in the metadata is not visible; the runner would not go on without it."""
    for name in GETTERS:
        setattr(runner, name, _forgiving(getattr(runner, name)))


def _forgiving(getter: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(getter)
    def found(*arguments: Any, **named: Any) -> Any:
        target = getter(*arguments, **named)
        if target is not None:
            return target
        name = next((value for value in (*arguments, *named.values()) if isinstance(value, str)), "")
        return {"objectId": name, "visible": False}

    return found
