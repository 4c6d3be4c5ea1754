"""Plug-ins: packages that bring settings, stages, rules and arms of their own.

An entry `name: module` in section `plugins` of the settings registers one; the module lists it in `PLUGINS`. The module is
installed, or lies beside the overlay that names it. Imports nothing heavy: the Snakefile imports it.
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
from ovman.workflow.stages import STAGES

S = TypeVar("S", bound=Settings)
T = TypeVar("T", bound=Section)


@dataclass(frozen=True)
class Plugin:
    """What a plug-in brings.

    name: of the plug-in and of its section of the settings. settings: model of that section. stages: for each of its stages the
    constants that the stage owns, "section.name" or "section.*", as in `ovman.workflow.stages`. rules: a .smk file that the
    Snakefile includes; it may use what workflow/rules/common.smk defines. scripts: folder with a script for each stage.

    Arms that say `made_by: name` get their predictions or rollouts from these rules. The rules also write the record
    results/notes/{name}.json (`ovman.records.note`).
    """

    name: str
    settings: type[Section]
    stages: Mapping[str, tuple[str, ...]]
    rules: Path
    scripts: Path


class PluginError(ValueError):
    """A module that is no plug-in; one line with the reason and the remedy."""


@cache
def plugin(name: str, module: str) -> Plugin:
    """The plug-in of an entry of section `plugins`. Raises PluginError."""
    try:
        listed = getattr(import_module(module), "PLUGINS", ())
    except ImportError as error:
        raise PluginError(f"cannot be imported ({error}); install it, or put it beside the overlay") from None
    except SyntaxError as error:
        raise PluginError(f"is not valid Python (line {error.lineno}: {error.msg}); correct it") from None
    plugins = {one.name: one for one in listed if isinstance(one, Plugin)}
    if not plugins:
        raise PluginError("has no PLUGINS of type ovman.settings.plugins.Plugin; name the module that has them")
    if name not in plugins:
        raise PluginError(f"has no plug-in of that name; it has {', '.join(plugins)}")
    found = plugins[name]
    if name in Settings.model_fields:
        raise PluginError(f"is called {name}, which is a section of ovman; rename the plug-in")
    if taken := sorted(set(found.stages) & set(STAGES)):
        raise PluginError(f"has a stage {taken[0]}, which is a stage of ovman; rename the stage")
    return found


def plugins_of(settings: Settings) -> tuple[Plugin, ...]:
    """The plug-ins that the settings name, in their order."""
    return tuple(plugin(name, module) for name, module in settings.plugins.items())


def stage_of_plugin(settings: Settings, stage: str) -> tuple[Plugin, str] | None:
    """The plug-in that has a stage, and its module; None for a stage of ovman."""
    for name, module in settings.plugins.items():
        found = plugin(name, module)
        if stage in found.stages:
            return found, module
    return None


def with_sections(model: type[S], plugins: Mapping[str, str]) -> type[S]:
    """`model` with the sections of these plug-ins (name -> module) as further fields. Raises PluginError."""
    return _with_sections(model, tuple(plugins.items()))


@cache
def _with_sections(model: type[S], plugins: tuple[tuple[str, str], ...]) -> type[S]:
    fields: dict[str, Any] = {name: (plugin(name, module).settings, ...) for name, module in plugins}
    return create_model(model.__name__, __base__=model, **fields) if fields else model


def section(settings: Settings, name: str, kind: type[T]) -> T:
    """The section of a plug-in, typed. Raises TypeError where the settings have another or none."""
    found = getattr(settings, name, None)
    if not isinstance(found, kind):
        raise TypeError(f"the settings have no section {name} of type {kind.__name__}; section plugins must name its plug-in")
    return found
