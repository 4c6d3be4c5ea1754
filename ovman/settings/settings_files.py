"""Files of settings, read as YAML or JSON; what is wrong with a file is one line with file, line, column and remedy.

Snakemake reads the files of --configfile before it reads the Snakefile, and answers a wrong one with a traceback or with a line
that does not name it. The profile in profiles/default therefore calls `check_command_line`, and the Snakefile
`check_file`, which refuse the file first. Imports
nothing heavy: it runs whenever Snakemake starts.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Hashable, Iterable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

import yaml

from ovman.faults import show

SECTIONS = "it must hold sections (benchmark:, camera:, ...)"

VALUES = 100_000
"""A file of settings has no more values, aliases written out; config.yaml has some thousands."""


class ConfigError(ValueError):
    """config.yaml or an overlay cannot be used; one line: the file, the setting and the remedy."""


def check_command_line(arguments: Sequence[str]) -> None:
    """Refuse, in one line and with SystemExit, a file of --configfile that does not hold settings. arguments: Snakemake's own."""
    parser = argparse.ArgumentParser(add_help=False, exit_on_error=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", default=[])
    try:
        options, _ = parser.parse_known_args(list(arguments))
    except argparse.ArgumentError:  # Snakemake says what is wrong with its own options
        return
    for path in options.configfile:
        check_file(path)


def check_file(path: str | Path) -> None:
    """Refuse, in one line and with SystemExit, a file that does not hold settings."""
    try:
        read_sections(Path(path))
    except ConfigError as error:
        raise SystemExit(str(error)) from None


def read_sections(path: Path) -> Mapping[Any, Any]:
    """Return the sections of a file of settings. ConfigError, in one line, for a file that has none."""
    tree = read(path)
    if tree is None:
        raise ConfigError(f"{path}: is empty; {SECTIONS}, or be left out")
    if not isinstance(tree, Mapping):
        raise ConfigError(f"{path}: holds {show(tree)}; {SECTIONS}")
    return tree


def with_parts(path: Path) -> list[Path]:
    """Return a file of settings with its parts: a config.yaml has more sections in the files of a folder config/ next to it."""
    return [path, *sorted(path.parent.glob("config/*.yaml"))] if path.name == "config.yaml" else [path]


def read_merged(files: Iterable[Path]) -> dict[Any, Any]:
    """Return the sections of all files. A later file wins, value by value, as Snakemake merges files of settings."""
    tree: dict[Any, Any] = {}
    for file in files:
        _merge(tree, read_sections(file))
    return tree


def _merge(tree: dict[Any, Any], over: Mapping[Any, Any]) -> None:
    for key, value in over.items():
        if isinstance(value, Mapping):  # copied, since aliases in a file share one mapping
            here = tree.get(key)
            tree[key] = here if isinstance(here, dict) else {}
            _merge(tree[key], value)
        else:
            tree[key] = value


def read(path: Path) -> Any:
    """Return the content of a YAML or JSON file. ConfigError, in one line, for a file that cannot be read."""
    try:
        content = path.read_bytes()
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}; give the path of a file of settings (.yaml)") from None
    text = _text(path, content)
    try:
        return json.loads(text, object_pairs_hook=_distinct)
    except (ValueError, RecursionError):
        pass
    try:
        tree = _tree(text)
    except yaml.reader.ReaderError as error:
        place = _place(text, error.position)
        raise ConfigError(f"{path}:{place}: holds the character U+{ord(text[error.position]):04X}; remove it") from None
    except yaml.MarkedYAMLError as error:
        raise ConfigError(f"{path}:{_marked(error)}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ConfigError(f"{path}: is no YAML ({' '.join(str(error).split())}); mend it") from None
    return tree


class _Distinct(yaml.constructor.SafeConstructor):
    """Construct what Snakemake would, but refuse a key that is there twice, and aliases that make too many values."""

    def construct_document(self, node: yaml.Node) -> Any:
        _count(node, {})
        return super().construct_document(node)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        for number, key in enumerate(keys):
            if key in keys[:number]:
                raise yaml.constructor.ConstructorError(problem=f"{key} is there twice", problem_mark=node.start_mark)
        return super().construct_mapping(node, deep)


class _Loader(_Distinct, yaml.SafeLoader):
    """YAML as Snakemake reads it."""


if yaml.__with_libyaml__:

    class _FastLoader(_Distinct, yaml.CSafeLoader):
        """The same with the parser in C, eight times as fast."""


def _tree(text: str) -> Any:
    """Return the content of a YAML text. If the parser in C refuses it, the one in Python reports the error."""
    if yaml.__with_libyaml__:
        with suppress(yaml.YAMLError, ValueError, RecursionError):
            return yaml.load(text, _FastLoader)  # noqa: S506 (a SafeLoader)
    return yaml.load(text, _Loader)  # noqa: S506 (a SafeLoader)


def _distinct(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len(dict(pairs)) < len(pairs):
        raise ValueError("a key is there twice")  # YAML's reader says which
    return dict(pairs)


def _text(path: Path, content: bytes) -> str:
    if content.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise ConfigError(f"{path}:1:1: is UTF-16 text; save it as UTF-8")
    try:
        return content.decode().removeprefix("\ufeff")
    except UnicodeDecodeError as error:
        before = content[: error.start].decode()
        byte = f"byte 0x{content[error.start]:02x}"
        raise ConfigError(f"{path}:{_place(before, len(before))}: is not UTF-8 text ({byte}); save it as UTF-8") from None


def _place(text: str, position: int) -> str:
    """Line and column, both from 1, of a position in a text."""
    return f"{text.count(chr(10), 0, position) + 1}:{position - text.rfind(chr(10), 0, position)}"


def _marked(error: yaml.MarkedYAMLError) -> str:
    """Line, column, problem and remedy of an error of YAML's reader."""
    mark, problem = error.problem_mark or error.context_mark, error.problem or "is no YAML"
    where = f"{mark.line + 1}:{mark.column + 1}" if mark is not None else "1:1"
    remedy = "write the values out" if "(*)" in problem else "mend the YAML there"
    remedy = "write it once" if "twice" in problem else "indent with spaces" if r"\t" in problem else remedy
    return f"{where}: {problem}; {remedy}"


def _count(node: yaml.Node, counts: dict[int, int]) -> int:
    """Return how many nodes a node has with its aliases written out. ConstructorError for more than `VALUES`, and for no end."""
    if isinstance(node, yaml.ScalarNode):
        return 1
    if id(node) not in counts:
        counts[id(node)] = 0
        pairs = isinstance(node, yaml.MappingNode)
        inner = [one for pair in node.value for one in pair] if pairs else node.value
        counts[id(node)] = 1 + sum(_count(one, counts) for one in inner)
    elif not counts[id(node)]:
        problem = "an alias (*) stands inside what it names"
        raise yaml.constructor.ConstructorError(problem=problem, problem_mark=node.start_mark)
    if counts[id(node)] > VALUES:
        problem = f"its aliases (*) make more than {VALUES} values"
        raise yaml.constructor.ConstructorError(problem=problem, problem_mark=node.start_mark)
    return counts[id(node)]
