"""AI2-THOR's client, loaded without what no run uses: its web server, and what downloads builds from a private store.

They are two thirds of its import, which every job with a simulator pays: 0.35 s of the processor against 0.13 s.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ai2thor.controller import Controller

POSTPONED = {"ai2thor.wsgi_server": "WsgiServer", "aws_requests_auth.boto_utils": "BotoAWSRequestsAuth", "requests": None}
"""Modules that the client imports at its start, and the class of each that it compares with or imports by name, if any."""


def controller() -> type[Controller]:
    """The class `ai2thor.controller.Controller`. What is postponed is loaded when the client first makes an object of it."""
    if "ai2thor.controller" not in sys.modules:
        with _postponed():
            import_module("ai2thor.controller")
    from ai2thor.controller import Controller

    found: type[Controller] = Controller
    return found


@contextmanager
def _postponed() -> Iterator[None]:
    """Stand-ins for what is not loaded yet; a later import gets the module itself."""
    import_module("ai2thor")
    standing = {name: _stand_in(name, of) for name, of in POSTPONED.items() if name not in sys.modules and find_spec(name)}
    sys.modules.update(standing)
    try:
        yield
    finally:
        for name, module in standing.items():
            if sys.modules.get(name) is module:
                del sys.modules[name]


def _stand_in(name: str, of: str | None) -> ModuleType:
    """A module with the attributes of the module `name`, loaded at the first. Its class `of` makes that module's objects."""
    module = ModuleType(name)

    def attribute(wanted: str) -> Any:
        if wanted.startswith("__"):  # the import itself asks
            raise AttributeError(wanted)
        return getattr(import_module(name), wanted)

    def make(_: type, *positional: Any, **named: Any) -> Any:
        return attribute(str(of))(*positional, **named)

    vars(module)["__getattr__"] = attribute
    if of is not None:
        vars(module)[of] = type(of, (), {"__new__": make})
    package, _, last = name.rpartition(".")
    if package:
        setattr(sys.modules[package], last, module)  # as an import does
    return module
