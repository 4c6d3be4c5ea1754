"""config.yaml, read: `load` refuses what is not a setting, or not a value, in one line that says what to write instead.

What a setting may be is in `ovman.settings`. Imports nothing heavy:
the Snakefile imports it.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ovman.faults import requirement, show
from ovman.settings import Settings
from ovman.settings.contradictions import contradictions
from ovman.settings.plugins import PluginError, settings_with
from ovman.settings.settings_files import ConfigError, read, read_merged, with_parts

__all__ = ["ConfigError", "file_with", "load", "load_files"]


def load(source: str | Path | Mapping[str, Any]) -> Settings:
    """Load the settings of a YAML file with its parts, or of a mapping. Sections that begin with "x-" are ignored.

    Raises:
        ConfigError: One line with file, setting and remedy.
    """
    return _validated(source, ()) if isinstance(source, Mapping) else load_files([source])


def load_files(files: Sequence[str | Path]) -> Settings:
    """Load the settings of a config.yaml with its parts, and of overlays on top of it. Later files win."""
    paths = [Path(file) for file in files]
    every = [*with_parts(paths[0]), *paths[1:]]
    return _validated(read_merged(every), every)


def _validated(tree: Mapping[str, Any], files: Sequence[Path]) -> Settings:
    model = _model(tree, files)
    try:
        settings = model.model_validate({name: value for name, value in tree.items() if not str(name).startswith("x-")})
    except ValidationError as error:
        raise ConfigError(_line(error, files, model)) from None
    for place, says in contradictions(settings):
        raise ConfigError(f"{file_with(files, place)}: {'.'.join(place)} {says}")
    return settings


def _model(tree: Mapping[str, Any], files: Sequence[Path]) -> type[Settings]:
    """Return the model with the sections of the plug-ins. The model reports a section of another form."""
    given = tree.get("plugins")
    named = given.items() if isinstance(given, Mapping) else ()
    plugins = {name: module for name, module in named if isinstance(name, str) and isinstance(module, str)}
    try:
        return settings_with(plugins)
    except PluginError as error:
        name, says = error.args
        where = file_with(files, ("plugins", name))
        raise ConfigError(f"{where}: plugins.{name} is {plugins[name]}, which {says}") from None


def file_with(files: Sequence[str | Path], location: Sequence[Any]) -> str:
    """Return the name of the last file with the setting at `location`, or of the first with a section that lacks it."""
    trees = [(Path(file).name, read(Path(file))) for file in files]
    for depth in range(len(location), 0, -1):
        holders = [name for name, tree in trees if _holds(tree, location[:depth])]
        if holders:
            return holders[-1 if depth == len(location) else 0]
    return trees[0][0] if trees else "config.yaml"


def _holds(tree: Any, location: Sequence[Any]) -> bool:
    for name in location:
        if not isinstance(tree, Mapping) or name not in tree:
            return False
        tree = tree[name]
    return bool(tree != {})


def _line(error: ValidationError, files: Sequence[Path], settings: type[Settings]) -> str:
    """Return the first thing that is wrong: where, what, and what to do."""
    # A name that is not a setting explains a setting that is missing.
    first = min(error.errors(), key=lambda e: {"extra_forbidden": 0, "missing": 2}.get(e["type"], 1))
    kind, value, expected = first["type"], first["input"], requirement(first)
    location = [name for name in first["loc"] if not isinstance(name, int)]
    path = [str(name) for name in location]
    where = ": ".join(filter(None, (file_with(files, location), ".".join(path))))
    model = _models(path[:-1], settings)
    if kind == "extra_forbidden":
        return f"{where} is not a setting; {_nearest(path, model, settings)}"
    field = None if model is None or not path else model.model_fields.get(path[-1])
    meaning = f" ({field.description})" if field is not None and field.description else ""
    if kind == "missing":
        remedy = "docs/agents.md shows an entry" if path[0] == "arms" else "the shipped config.yaml or config/ has its value"
        if path[0] not in Settings.model_fields:
            remedy = "the plug-in's own overlay has its value"
        return f"{where}{meaning} is missing; add it, {remedy}"
    if kind == "value_error":
        return f"{where}: {first['msg'].removeprefix('Value error, ')}"
    if kind in ("model_type", "model_attributes_type"):
        return f"{where} is {show(value)}; it must be a section with settings of its own"
    hint = "; write numbers without quotes" if isinstance(value, str) and expected in ("a number", "an integer") else ""
    return f"{where} is {show(value)}; it must be {expected or first['msg']}{meaning}{hint}"


def _models(path: Sequence[str], settings: type[Settings]) -> type[BaseModel] | None:
    """Return the model of the section at a path; entries of a mapping have the model of its values."""
    model: Any = settings
    for name in path:
        if get_origin(model) is dict:
            model = get_args(model)[1]
        elif isinstance(model, type) and issubclass(model, BaseModel) and name in model.model_fields:
            model = model.model_fields[name].annotation
        else:
            return None
    return model if isinstance(model, type) and issubclass(model, BaseModel) else None


def _nearest(path: Sequence[str], model: type[BaseModel] | None, settings: type[Settings]) -> str:
    """Return the nearest setting to a wrong name: one of that name in another section, then in its own section, then anywhere."""
    here = list(model.model_fields) if model is not None else []
    # Of settings of one name, the first is meant: a later section varies what an earlier one sets.
    everywhere = {} if path[0] == "arms" else {n.rsplit(".", 1)[-1]: n for n in reversed([*_names(settings)])}
    for cutoff, names in (
        (0.9, {**everywhere, **{name: name for name in here}}),
        (0.5, {name: name for name in here}),
        (0.7, everywhere),
    ):
        if near := difflib.get_close_matches(path[-1], names, n=1, cutoff=cutoff):
            return f"did you mean {names[near[0]]}?"
    return f"{'.'.join(path[:-1]) or 'config.yaml'} has {', '.join(here)}"


def _names(model: type[BaseModel], path: str = "") -> Iterator[str]:
    for name, field in model.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _names(kind, f"{path}{name}.")
        else:
            yield f"{path}{name}"
