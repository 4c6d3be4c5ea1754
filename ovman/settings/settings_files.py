"""Files of settings, read as YAML; what is wrong with a file is one line with file, line, column and remedy.

Snakemake reads the files of --configfile before it reads the Snakefile, and answers a wrong one with a traceback or with a line
that does not name it. The profile in profiles/default therefore calls `check_command_line`, which refuses the file first. Imports
nothing heavy: it runs whenever Snakemake starts.
"""

from __future__ import annotations

import argparse
from collections.abc import Hashable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from ovman.faults import show

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
    try:
        read_merged(map(Path, options.configfile))
    except ConfigError as error:
        raise SystemExit(str(error)) from None


def with_parts(path: Path) -> list[Path]:
    """Return a file of settings with its parts: a config.yaml has more sections in the files of a folder config/ next to it."""
    return [path, *sorted(path.parent.glob("config/*.yaml"))] if path.name == "config.yaml" else [path]


def read_merged(files: Iterable[Path]) -> dict[Any, Any]:
    """Return the sections of all files; a later file wins, value by value. ConfigError, in one line, for a file without any."""
    merged: dict[Any, Any] = {}
    for file in files:
        tree = read(file)
        if not isinstance(tree, Mapping):
            holds = "is empty" if tree is None else f"holds {show(tree)}"
            raise ConfigError(f"{file}: {holds}; it must hold sections (benchmark:, camera:, ...)")
        _merge(merged, tree)
    return merged


def _merge(tree: dict[Any, Any], over: Mapping[Any, Any]) -> None:
    for key, value in over.items():
        if isinstance(value, Mapping):  # copied, since aliases in a file share one mapping
            here = tree.get(key)
            tree[key] = here if isinstance(here, dict) else {}
            _merge(tree[key], value)
        else:
            tree[key] = value


def read(path: Path) -> Any:
    """Return the content of a YAML file. ConfigError, in one line, for a file that cannot be read."""
    try:
        content = path.read_bytes()
        text = content.decode("utf-8-sig")
    except OSError as error:
        raise ConfigError(f"{path}: {error.strerror}; give the path of a file of settings (.yaml)") from None
    except UnicodeDecodeError as error:
        place = _place(content[: error.start].decode())
        raise ConfigError(f"{path}:{place}: is not UTF-8 text (byte 0x{content[error.start]:02x}); save it as UTF-8") from None
    if bad := yaml.reader.Reader.NON_PRINTABLE.search(text):
        raise ConfigError(f"{path}:{_place(text[: bad.start()])}: holds the character U+{ord(bad[0]):04X}; remove it")
    try:
        return yaml.load(text, _Loader)  # noqa: S506 (a SafeLoader)
    except yaml.MarkedYAMLError as error:
        raise ConfigError(f"{path}:{_marked(error, text)}") from None
    except (yaml.YAMLError, ValueError, RecursionError) as error:
        raise ConfigError(f"{path}: is no YAML ({' '.join(str(error).split())}); mend it") from None


def _place(before: str) -> str:
    """Return line and column, both from 1, of what follows a text."""
    return f"{before.count(chr(10)) + 1}:{len(before) - before.rfind(chr(10))}"


class _Loader(yaml.CSafeLoader):
    """YAML as Snakemake reads it, but without keys that are there twice, and aliases that make too many values."""

    def construct_document(self, node: yaml.Node) -> Any:
        _count(node, {})
        return super().construct_document(node)

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict[Hashable, Any]:
        keys = [self.construct_object(key, deep=True) for key, _ in node.value if key.tag != "tag:yaml.org,2002:merge"]
        for number, key in enumerate(keys):
            if key in keys[:number]:
                raise yaml.constructor.ConstructorError(problem=f"{key} is there twice", problem_mark=node.start_mark)
        return super().construct_mapping(node, deep)


def _marked(error: yaml.MarkedYAMLError, text: str) -> str:
    """Line, column, problem and remedy of an error of YAML's reader."""
    mark, problem = error.problem_mark or error.context_mark, error.problem or "is no YAML"
    line, column = (0, 0) if mark is None else (mark.line, mark.column)
    has_tab = "\t" in "".join(text.split("\n")[line : line + 1])[column : column + 1]  # the end of a text is a line below it
    remedy = "write the values out" if "(*)" in problem else "write it once" if "twice" in problem else "mend the YAML there"
    return f"{line + 1}:{column + 1}: {problem}; {'indent with spaces' if has_tab else remedy}"


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
