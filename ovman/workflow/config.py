"""config.yaml, read: `load` refuses what is not a setting, or not a value, in one line that says what to write instead.

What a setting may be is in `ovman.models.settings`, which stage owns it in `ovman.workflow.stages`. Imports nothing heavy:
the Snakefile imports it.
"""

from __future__ import annotations

import difflib
import json
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, get_args, get_origin

import yaml
from pydantic import BaseModel, ValidationError

from ovman.models.settings import Arm, Settings
from ovman.workflow.parameter import flat
from ovman.workflow.plugins import PluginError, plugin, with_sections
from ovman.workflow.stages import matching

__all__ = ["ConfigError", "file_with", "load"]

# What is measured must serve the verdict in force: (verdict, bound, how the bound must compare).
_BOUNDS = (
    ("admissibility.min_mask_px", "measurement.min_mask_px", "at most"),
    ("success.visible_px", "measurement.visible_px", "at most"),
    ("admissibility.validity_radius_m", "measurement.answer_to_navigable_m", "at least"),
)


def contradictions(arms: Mapping[str, Arm], names: Iterable[str]) -> tuple[tuple[str, ...], str] | None:
    """The first thing in section `arms` that fits nothing else in the settings: its place, and what is to be said of it."""
    for name, arm in arms.items():
        for pattern in arm.constants:
            if not matching([pattern], names) or pattern == "arms":
                return ("arms", name, "constants"), f'names {pattern}, which is no setting; write "section.name" or "section.*"'
        foreign = ("expected", "runs") if arm.kind == "embodied" else ("executes", "embodiment", "budget", "cut_from")
        for field in foreign:
            if getattr(arm, field) != Arm.model_fields[field].default:
                return ("arms", name, field), f"is not for an arm that is {arm.kind}; take it out"
        for field, kind in (("executes", "static"), ("cut_from", "embodied")):
            other = getattr(arm, field)
            if other is not None and (other not in arms or arms[other].kind != kind):
                there = ", ".join(one for one, entry in arms.items() if entry.kind == kind and one != name)
                return ("arms", name, field), f"is {other}, which is no {kind} arm; there are {there or 'none'}"
        if arm.cut_from is not None:
            whole = arms[arm.cut_from]
            if whole.cut_from is not None or arm.budget is None or (whole.budget is not None and whole.budget < arm.budget):
                says = "from whose runs it cannot be cut; name an arm that drives itself, for no fewer actions than `budget`"
                return ("arms", name, "cut_from"), f"is {arm.cut_from}, {says}"
    return None


class ConfigError(ValueError):
    """config.yaml cannot be used; one line: the file, the setting and the remedy."""


def load(source: str | Path | Mapping[str, Any], files: Sequence[str | Path] = ()) -> Settings:
    """The settings of a YAML file or of a mapping. Sections that begin with "x-" are the user's own and are ignored.

    `files` are those that a mapping was merged from, later ones winning; an error names the one that has the wrong setting.
    Raises ConfigError in one line.
    """
    if isinstance(source, Mapping):
        tree, files = source, [Path(f) for f in files]
    else:
        tree, files = _read(Path(source)), [Path(source)]
    if not isinstance(tree, Mapping):
        raise ConfigError(f"{file_with(files, ())}: holds {_shown(tree)}; it must hold sections (benchmark:, camera:, ...)")
    model = with_sections(Settings, _plugins(tree, files))
    try:
        config = model.model_validate({k: v for k, v in _in_order(tree, files).items() if not str(k).startswith("x-")})
    except ValidationError as error:
        raise ConfigError(_line(error, files, model)) from None
    values = flat(config)
    for name, arm in config.arms.items():
        if arm.made_by is not None and arm.made_by not in config.plugins:
            says = f"is {arm.made_by}, which is not in section plugins; there are {', '.join(config.plugins) or 'none'}"
            raise ConfigError(f"{file_with(files, ('arms', name, 'made_by'))}: arms.{name}.made_by {says}")
    if contradiction := contradictions(config.arms, values):
        key, says = contradiction
        raise ConfigError(f"{file_with(files, key)}: {'.'.join(key)} {says}")
    for verdict, bound, needed in _BOUNDS:
        if values[bound] > values[verdict] if needed == "at most" else values[bound] < values[verdict]:
            where = file_with(files, tuple(verdict.split(".")))
            needs = f"{bound} must be {needed} that and is {values[bound]}"
            raise ConfigError(f"{where}: {verdict} is {values[verdict]}, but {needs}; change one of the two")
    return config


def _plugins(tree: Mapping[str, Any], files: Sequence[Path]) -> Mapping[str, str]:
    """Section `plugins`, each entry checked. ConfigError in one line; what has another form is left to the model."""
    given = tree.get("plugins")
    if not isinstance(given, Mapping):
        return {}
    named = {name: module for name, module in given.items() if isinstance(name, str) and isinstance(module, str)}
    for name, module in named.items():
        try:
            plugin(name, module)
        except PluginError as error:
            raise ConfigError(f"{file_with(files, ('plugins', name))}: plugins.{name} is {module}, which {error}") from None
    return named


def _in_order(tree: Mapping[str, Any], files: Sequence[Path]) -> Mapping[str, Any]:
    """The tree with its arms in the order of the files: whoever merges files may begin with the last one's keys."""
    arms = tree.get("arms")
    if len(files) < 2 or not isinstance(arms, Mapping):
        return tree
    sections = [read.get("arms") for path in files if isinstance(read := _read(path), Mapping)]
    names = dict.fromkeys(name for section in sections if isinstance(section, Mapping) for name in section)
    return {**tree, "arms": {name: arms[name] for name in (*names, *arms) if name in arms}}


class _Loader(yaml.SafeLoader):
    """YAML as Snakemake reads it, but a key that is there twice is an error."""

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Any, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        for key in keys:
            if keys.count(key) > 1:
                raise yaml.constructor.ConstructorError(problem=f"{key} is there twice", problem_mark=node.start_mark)
        return super().construct_mapping(node, deep)


def _read(path: Path) -> Any:
    try:
        return yaml.load(path.read_text(encoding="utf-8"), _Loader)  # noqa: S506 (a SafeLoader)
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}; give the path of a config.yaml") from None
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is not UTF-8 text") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark
        raise ConfigError(f"{path}:{mark.line + 1 if mark else 1}: {error.problem}") from None
    except yaml.YAMLError as error:
        raise ConfigError(f"{path}: {' '.join(str(error).split())}") from None


def file_with(files: Sequence[str | Path], location: Sequence[Any]) -> str:
    """Name of the last file that has the setting at `location`; config.yaml where none is known."""
    for path in reversed([Path(f) for f in files]):
        here: Any = _read(path) if len(files) > 1 else {}
        for name in location:
            here = here.get(name, _ABSENT) if isinstance(here, Mapping) else _ABSENT
        if here is not _ABSENT and here != {}:
            return path.name
    return Path(files[0]).name if files else "config.yaml"


_ABSENT = object()


def _line(error: ValidationError, files: Sequence[str | Path], settings: type[Settings]) -> str:
    """The first thing that is wrong: where, what, and what to do."""
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
        remedy = "docs/agents.md shows an entry" if path[0] == "arms" else "the repository's config.yaml has its value"
        if path[0] not in Settings.model_fields:
            remedy = "the plug-in's own overlay has its value"
        return f"{where}: {name}{meaning} is missing; add it, {remedy}"
    value, says = first["input"], re.sub(r"^(Input should|Value should|Value error,|Tuple should) ", "", first["msg"])
    says = re.sub(r" after validation, not \d+$", "", says).replace("tuple", "list")
    if first["type"] == "value_error":
        return f"{where}: {name}: {says}"
    if first["type"] in ("model_type", "model_attributes_type"):
        return f"{where}: {name} is {_shown(value)}; it must be a section with settings of its own"
    hint = (
        "; write numbers without quotes, and give changes as a file (--configfile)"
        if isinstance(value, str) and "valid" in says
        else ""
    )
    return f"{where}: {name} is {_shown(value)}; it must {says}{meaning}{hint}"


def _shown(value: Any) -> str:
    text = json.dumps(value, default=str) if not isinstance(value, float) else repr(value)
    return text if len(text) <= 60 else text[:57] + "..."


def _models(path: Sequence[str], settings: type[Settings]) -> type[BaseModel] | None:
    model: Any = settings
    names = iter(path)
    for name in names:
        field = model.model_fields.get(name)
        model = field.annotation if field is not None else None
        if get_origin(model) is dict and next(names, None) is not None:
            model = get_args(model)[1]
        if not (isinstance(model, type) and issubclass(model, BaseModel)):
            return None
    return model


def _field(path: Sequence[str], settings: type[Settings]) -> Any:
    model = _models(path[:-1], settings)
    return None if model is None or not path else model.model_fields.get(path[-1])


def _nearest(path: Sequence[str], settings: type[Settings]) -> str:
    """The nearest setting to a wrong name: in its own section first, then anywhere."""
    model, wrong = _models(path[:-1], settings), path[-1]
    here = list(model.model_fields) if model is not None else []
    everywhere = {} if path[0] == "arms" else {n.rsplit(".", 1)[-1]: n for n in _names(settings)}
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
