"""Plug-ins: packages that bring a section of settings, rules and arms of their own.

An entry `name: module` in section `plugins` of the settings registers one; the module lists it in `PLUGINS`. The module is
installed, or lies next to the overlay that names it. Imports nothing heavy: the Snakefile imports it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

from pydantic import create_model

from ovman.settings import Section, Settings

T = TypeVar("T", bound=Section)


@dataclass(frozen=True)
class Plugin:
    """A plug-in.

    Arms with `made_by: name` get their predictions or rollouts from its rules. The rules also write the record
    results/notes/{name}.json (`ovman.records.note`).

    Attributes:
        name: Name of the plug-in and of its section of the settings.
        settings: Model of that section.
        rules: A .smk file that the workflow includes; it may use everything that workflow/rules/common.smk defines.
    """

    name: str
    settings: type[Section]
    rules: Path


class PluginError(ValueError):
    """A module that is not a plug-in: its name in section `plugins`, and in one line the reason and the remedy."""


@cache
def load_plugin(name: str, module: str) -> Plugin:
    """Import the plug-in of an entry of section `plugins`. Raises PluginError."""
    try:
        listed = getattr(import_module(module), "PLUGINS", ())
    except ImportError as error:
        raise PluginError(name, f"cannot be imported ({error}); install it, or put it next to the overlay") from None
    except SyntaxError as error:
        raise PluginError(name, f"is not valid Python (line {error.lineno}: {error.msg}); correct it") from None
    plugins = {one.name: one for one in listed if isinstance(one, Plugin)}
    if not plugins:
        raise PluginError(name, "has no PLUGINS of type ovman.settings.plugins.Plugin; name the module that has them")
    if name not in plugins:
        raise PluginError(name, f"has no plug-in of that name; it has {', '.join(plugins)}")
    if name in Settings.model_fields:
        raise PluginError(name, f"is called {name}, which is a section of ovman; rename the plug-in")
    return plugins[name]


def plugins_of(settings: Settings) -> tuple[Plugin, ...]:
    """Return the plug-ins that the settings name, in their order."""
    return tuple(load_plugin(name, module) for name, module in settings.plugins.items())


def settings_with(plugins: Mapping[str, str]) -> type[Settings]:
    """Return the model of the settings with the sections of these plug-ins (name -> module). Raises PluginError."""
    fields: dict[str, Any] = {name: (load_plugin(name, module).settings, ...) for name, module in plugins.items()}
    return create_model("Settings", __base__=Settings, **fields) if fields else Settings


def section(settings: Settings, name: str, kind: type[T]) -> T:
    """Return the section of a plug-in, typed. Raises TypeError if the settings have another section of this name, or none."""
    found = getattr(settings, name, None)
    if not isinstance(found, kind):
        raise TypeError(f"the settings have no section {name} of type {kind.__name__}; section plugins must name its plug-in")
    return found
