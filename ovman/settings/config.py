"""config.yaml, read: `load` refuses what is not a setting, or not a value, in one line that says what to write instead.

What a setting may be is in `ovman.settings`. Imports nothing heavy:
the Snakefile imports it.
"""

from __future__ import annotations

import difflib
import operator
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from ovman.faults import requirement, show
from ovman.settings import MAIN, Arm, Kind, Need, Settings
from ovman.settings.arms import contradictions as of_withheld
from ovman.settings.comparisons import comparison_contradictions, sensitivity_contradictions
from ovman.settings.plugins import PluginError, load_plugin, with_sections
from ovman.settings.settings import matching
from ovman.settings.settings_files import ConfigError, read, read_merged, with_parts

__all__ = ["ConfigError", "file_with", "load", "load_files"]

Contradiction = tuple[tuple[str, ...], str]
"""The place of a setting, and what is wrong with its value and what to do."""


def contradictions(settings: Settings) -> Iterator[Contradiction]:
    """Yield values that contradict each other although each is allowed."""
    yield from _of_measurement(settings)
    yield from _of_counts(settings)
    yield from _of_motion(settings)
    yield from _of_arms(settings.arms, settings.plugins, settings.constants())
    yield from of_withheld(settings.arms)
    yield from comparison_contradictions(settings.comparisons, settings.arms)
    yield from _of_splits(settings)
    yield from sensitivity_contradictions(settings.sensitivity, settings.measurement)
    yield from _of_appearance(settings.appearance.agent, settings.arms)


def _of_measurement(settings: Settings) -> Iterator[Contradiction]:
    """Yield bounds of measurement that are stricter than the verdict in force."""
    measured, verdict, success = settings.measurement, settings.admissibility, settings.success
    for key, value, bound, limit, fits, word in (
        ("admissibility.min_mask_px", verdict.min_mask_px, "min_mask_px", measured.min_mask_px, operator.le, "at most"),
        ("success.visible_px", success.visible_px, "visible_px", measured.visible_px, operator.le, "at most"),
        (
            "admissibility.validity_radius_m",
            verdict.validity_radius_m,
            "answer_to_navigable_m",
            measured.answer_to_navigable_m,
            operator.ge,
            "at least",
        ),
    ):
        if not fits(limit, value):
            says = f"measurement.{bound} must be {word} that and is {limit}; change one of the two"
            yield tuple(key.split(".")), f"is {value}, but {says}"


def _of_counts(settings: Settings) -> Iterator[Contradiction]:
    """Yield splits with more episodes than candidates, and main without episodes."""
    for name, split in settings.splits.items():
        scenes = len(split.scenes)
        for relation, episodes in split.episodes:
            if episodes > (draws := getattr(split.draws, relation)) * scenes:
                says = f"splits.{name}.draws.{relation} x scenes are {draws} x {scenes} = {draws * scenes}; lower it or draw more"
                yield ("splits", name, "episodes", relation), f"is {episodes}, but {says}"
    if not any(episodes for _, episodes in settings.splits[MAIN].episodes):
        yield ("splits", MAIN, "episodes"), "asks for no episode; give at least one relation a number above 0"


def _of_motion(settings: Settings) -> Iterator[Contradiction]:
    """Yield turns with which the agent cannot face every direction."""
    primitives = settings.primitives
    turn, tolerance = primitives.turn_deg, primitives.heading_tolerance_deg
    if 360.0 % turn:
        yield ("primitives", "turn_deg"), f"is {turn}, which does not divide 360; write a divisor of 360, such as 30"
    elif tolerance < turn / 2:
        says = f"half of primitives.turn_deg ({turn}): some headings could not be reached; write at least {turn / 2}"
        yield ("primitives", "heading_tolerance_deg"), f"is {tolerance}, which is less than {says}"
    local = settings.dualmap.local_map
    if local.split_frames >= local.split_window:
        says = f"the {local.split_window} keyframes of dualmap.local_map.split_window never hold more; lower it"
        yield ("dualmap", "local_map", "split_frames"), f"is {local.split_frames}, but {says}"


def _of_appearance(agent: str, arms: Mapping[str, Arm]) -> Iterator[Contradiction]:
    if agent not in arms or arms[agent].kind is not Kind.STATIC or Need.MAPS not in arms[agent].needs or arms[agent].expected:
        says = "which is not a static arm that answers from maps of both visits; name one"
        yield ("appearance", "agent"), f"is {agent}, {says}"


def _of_splits(settings: Settings) -> Iterator[Contradiction]:
    """Yield arms that answer main alone in other splits, and scenes shared by splits that are toured apart.

    An arm that does not exist is left out of its splits, too.
    """
    arms = settings.arms
    job = {scene for split in settings.splits.values() if split.in_main_job for scene in split.scenes}
    for name, split in settings.splits.items():
        for number, arm in enumerate(split.arms if name != MAIN else ()):
            place = ("splits", name, "arms", str(number))
            if arm in arms and (arms[arm].made_by is not None or Need.DUALMAP in arms[arm].needs):
                yield place, f"is {arm}, whose records are made of split {MAIN} alone; name another arm"
        if not split.in_main_job and (shared := sorted(job & {*split.scenes})):
            says = f"but {shared[0]} is a scene of the main job; name other scenes, or set in_main_job to true"
            yield ("splits", name, "in_main_job"), f"is false, {says}"


def _of_arms(arms: Mapping[str, Arm], plugins: Iterable[str], names: Iterable[str]) -> Iterator[Contradiction]:
    """Arms name settings, plug-ins and other arms that exist, and have the fields of their kind."""
    for name, arm in arms.items():
        if arm.made_by is not None and arm.made_by not in plugins:
            listed = ", ".join(plugins) or "none"
            yield ("arms", name, "made_by"), f"is {arm.made_by}, which is not in section plugins; the plug-ins are {listed}"
        for pattern in arm.constants:
            if not matching([pattern], names) or pattern == "arms":
                yield ("arms", name, "constants"), f'names {pattern}, which is not a setting; write "section.name" or "section.*"'
        foreign = ("expected", "runs") if arm.kind == "embodied" else ("executes", "embodiment", "budget", "cut_from")
        for field in foreign:
            if getattr(arm, field) != Arm.model_fields[field].default:
                yield ("arms", name, field), f"is not for an arm that is {arm.kind}; take it out"
        for field, kind in (("executes", "static"), ("cut_from", "embodied")):
            other = getattr(arm, field)
            if other is not None and (other not in arms or arms[other].kind != kind):
                there = ", ".join(one for one, entry in arms.items() if entry.kind == kind and one != name)
                yield ("arms", name, field), f"is {other}, which is not a known {kind} arm; there are {there or 'none'}"
        whole = None if arm.cut_from is None else arms.get(arm.cut_from)
        if whole is not None and not _can_be_cut(whole, arm):
            says = "from whose runs it cannot be cut; name an arm that drives itself, for no fewer actions than `budget`"
            yield ("arms", name, "cut_from"), f"is {arm.cut_from}, {says}"


def _can_be_cut(whole: Arm, arm: Arm) -> bool:
    """Return whether the runs of `whole` contain those of `arm`, which end after fewer actions."""
    return whole.cut_from is None and arm.budget is not None and (whole.budget is None or whole.budget >= arm.budget)


def load(source: str | Path | Mapping[str, Any], files: Sequence[str | Path] = ()) -> Settings:
    """Load the settings of a YAML file with its parts, or of a mapping. Sections that begin with "x-" are ignored.

    Args:
        source: A file, or the mapping that Snakemake merged from `files`.
        files: Where a mapping comes from, later ones winning. An error names the file that has the wrong setting.

    Raises:
        ConfigError: One line with file, setting and remedy.
    """
    if isinstance(source, Mapping):
        return _validated(source, _with_parts_of_first(files))
    return load_files([source])


def load_files(files: Sequence[str | Path]) -> Settings:
    """Load the settings of a config.yaml with its parts, and of overlays on top of it. Later files win."""
    every = _with_parts_of_first(files)
    return _validated(read_merged(every), every)


def _with_parts_of_first(files: Sequence[str | Path]) -> list[Path]:
    paths = [Path(file) for file in files]
    return list(dict.fromkeys([*with_parts(paths[0]), *paths])) if paths else []


def _validated(tree: Mapping[str, Any], files: Sequence[Path]) -> Settings:
    model = with_sections(Settings, _plugins(tree, files))
    try:
        config = model.model_validate({k: v for k, v in _in_order(tree, files).items() if not str(k).startswith("x-")})
    except ValidationError as error:
        raise ConfigError(_line(error, files, model)) from None
    for key, says in contradictions(config):
        raise ConfigError(f"{file_with(files, key)}: {'.'.join(key)} {says}")
    return config


def _plugins(tree: Mapping[str, Any], files: Sequence[str | Path]) -> Mapping[str, str]:
    """Section `plugins`, each entry checked. ConfigError in one line; what has another form is left to the model."""
    given = tree.get("plugins")
    if not isinstance(given, Mapping):
        return {}
    named = {name: module for name, module in given.items() if isinstance(name, str) and isinstance(module, str)}
    for name, module in named.items():
        try:
            load_plugin(name, module)
        except PluginError as error:
            raise ConfigError(f"{file_with(files, ('plugins', name))}: plugins.{name} is {module}, which {error}") from None
    return named


def _in_order(tree: Mapping[str, Any], files: Sequence[str | Path]) -> Any:
    """Return the tree with its keys in the order of the files: a merge may begin with the last file's keys."""
    return tree if len(files) < 2 else _ordered(tree, [read(Path(path)) for path in files])


def _ordered(value: Any, sources: Sequence[Any]) -> Any:
    sources = [source for source in sources if isinstance(source, Mapping)]
    if not isinstance(value, Mapping):
        return value
    names = dict.fromkeys(name for source in (*sources, value) for name in source)
    return {name: _ordered(value[name], [source.get(name) for source in sources]) for name in names if name in value}


def file_with(files: Sequence[str | Path], location: Sequence[Any]) -> str:
    """Return the name of the last file with the setting at `location`, or of the first with a section that lacks it."""
    if len(files) < 2:
        return Path(files[0]).name if files else "config.yaml"
    trees = [(Path(file).name, read(Path(file))) for file in files]
    for depth in range(len(location), 0, -1):
        holders = [name for name, tree in trees if _holds(tree, location[:depth])]
        if holders:
            return holders[-1 if depth == len(location) else 0]
    return trees[0][0]


def _holds(tree: Any, location: Sequence[Any]) -> bool:
    for name in location:
        if not isinstance(tree, Mapping) or name not in tree:
            return False
        tree = tree[name]
    return bool(tree != {})


def _line(error: ValidationError, files: Sequence[str | Path], settings: type[Settings]) -> str:
    """Return the first thing that is wrong: where, what, and what to do."""
    # A name that is not a setting explains a setting that is missing.
    first = min(error.errors(), key=lambda e: {"extra_forbidden": 0, "missing": 2}.get(e["type"], 1))
    location = tuple(first["loc"])
    path = [str(name) for name in location if not isinstance(name, int)]
    name = ".".join(path)
    where = file_with(files, [p for p in location if not isinstance(p, int)])
    if first["type"] == "extra_forbidden":
        return f"{where}: {name} is not a setting; {_nearest(path, settings)}"
    field = _field(path, settings)
    meaning = f" ({field.description})" if field is not None and field.description else ""
    if first["type"] == "missing":
        remedy = "docs/agents.md shows an entry" if path[0] == "arms" else "the shipped config.yaml or config/ has its value"
        if path[0] not in Settings.model_fields:
            remedy = "the plug-in's own overlay has its value"
        return f"{where}: {name}{meaning} is missing; add it, {remedy}"
    value, expected = first["input"], requirement(first)
    if first["type"] == "value_error":
        return f"{where}: {name}: {first['msg'].removeprefix('Value error, ')}"
    if first["type"] in ("model_type", "model_attributes_type"):
        return f"{where}: {name} is {show(value)}; it must be a section with settings of its own"
    numeric = isinstance(value, str) and expected in ("a number", "an integer")
    hint = "; write numbers without quotes, and give changes as a file (--configfile)" if numeric else ""
    return f"{where}: {name} is {show(value)}; it must be {expected or first['msg']}{meaning}{hint}"


def _models(path: Sequence[str], settings: type[Settings]) -> type[BaseModel] | None:
    model: type[BaseModel] = settings
    names = iter(path)
    for name in names:
        field = model.model_fields.get(name)
        inner: Any = field.annotation if field is not None else None
        if get_origin(inner) is dict and next(names, None) is not None:
            inner = get_args(inner)[1]
        if not (isinstance(inner, type) and issubclass(inner, BaseModel)):
            return None
        model = inner
    return model


def _field(path: Sequence[str], settings: type[Settings]) -> Any:
    model = _models(path[:-1], settings)
    return None if model is None or not path else model.model_fields.get(path[-1])


def _nearest(path: Sequence[str], settings: type[Settings]) -> str:
    """Return the nearest setting to a wrong name: in its own section first, then anywhere."""
    model, wrong = _models(path[:-1], settings), path[-1]
    here = list(model.model_fields) if model is not None else []
    # Of settings of one name, the first is meant: a later section varies what an earlier one sets.
    everywhere = {} if path[0] == "arms" else {n.rsplit(".", 1)[-1]: n for n in reversed([*_names(settings)])}
    for cutoff, elsewhere in ((0.9, True), (0.5, False), (0.7, True)):
        near = difflib.get_close_matches(wrong, here, n=1, cutoff=cutoff)
        if near:
            return f"did you mean {near[0]}?"
        near = difflib.get_close_matches(wrong, list(everywhere), n=1, cutoff=cutoff) if elsewhere else []
        if near:
            return f"did you mean {everywhere[near[0]]}?"
    return f"{'.'.join(path[:-1]) or 'config.yaml'} has {', '.join(here)}"


def _names(model: type[BaseModel], path: str = "") -> Iterator[str]:
    for name, field in model.model_fields.items():
        kind = field.annotation
        if isinstance(kind, type) and issubclass(kind, BaseModel):
            yield from _names(kind, f"{path}{name}.")
        else:
            yield f"{path}{name}"
