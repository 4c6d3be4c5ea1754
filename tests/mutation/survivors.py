"""Mutation testing: runs mutmut and compares the mutants that survive with those that survivors.toml explains.

`make mutants` runs it. It fails on a survivor without an explanation and on an explanation without a survivor. A mutant is known
by its function, the line and the mutated line, because mutmut's own numbers shift with every change of the function.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
EXPLAINED = Path(__file__).with_name("survivors.toml")
NOTICED = frozenset({"killed", "timeout", "segfault", "suspicious", "caught by type check"})
"""States in which the tests tell a mutant from the code; mutmut calls an unusual exit of pytest suspicious."""
UNREACHED = "no tests"
"""The state of a mutant of a function that no selected test reaches."""


@dataclass(frozen=True, order=True)
class Mutant:
    """A changed line: dotted name of the function, the line, what became of it (both stripped, empty where one is missing)."""

    function: str
    line: str
    mutant: str

    def __str__(self) -> str:
        return f"{self.function}\n    - {self.line}\n    + {self.mutant}"


@dataclass(frozen=True)
class Comparison:
    """Survivors that nothing explains, and explanations of mutants that do not survive (any more)."""

    unexplained: tuple[Mutant, ...]
    stale: tuple[Mutant, ...]


def read_explained(file: Path = EXPLAINED) -> dict[Mutant, str]:
    """The reason of every explained survivor. Raises ValueError for an empty reason and for a mutant that is explained twice."""
    explained: dict[Mutant, str] = {}
    for entry in tomllib.loads(file.read_text()).get("survivor", []):
        if not entry["reason"].strip():
            raise ValueError(f"{file.name}: {entry['function']} has no reason")
        for text in entry["mutants"]:
            mutant = Mutant(entry["function"], entry["line"], text)
            if mutant in explained:
                raise ValueError(f"{file.name} explains a mutant twice: {mutant}")
            explained[mutant] = entry["reason"]
    return explained


def read_elsewhere(file: Path = EXPLAINED) -> dict[str, str]:
    """The tests that run each function which no selected test reaches. Raises ValueError for tests that are not there."""
    elsewhere: dict[str, str] = {}
    for entry in tomllib.loads(file.read_text()).get("elsewhere", []):
        if not (ROOT / entry["tests"]).exists():
            raise ValueError(f"{file.name}: {entry['tests']} is not there")
        elsewhere |= dict.fromkeys(entry["functions"], entry["tests"])
    return elsewhere


def compare(survivors: Iterable[Mutant], explained: Iterable[Mutant]) -> Comparison:
    """Both sides without what they share, sorted."""
    found, known = set(survivors), set(explained)
    return Comparison(tuple(sorted(found - known)), tuple(sorted(known - found)))


def changed_line(function: str, diff: str) -> Mutant:
    """The mutant that a unified diff shows. Lines that belong together are joined by a line break."""
    removed, added = (
        "\n".join(line[1:].strip() for line in diff.splitlines() if line.startswith(sign) and not line.startswith(sign * 3))
        for sign in "-+"
    )
    return Mutant(function, removed, added)


@dataclass(frozen=True)
class Result:
    """What became of one mutant. function: its dotted name; state: as mutmut says; survivor: None where noticed or unreached."""

    package: str
    function: str
    state: str
    survivor: Mutant | None


def results(pattern: str) -> Iterator[Result]:
    """The results in mutants/ of all mutants whose names match `pattern`. The working directory is the repository's root."""
    from fnmatch import fnmatch

    from mutmut.mutation.data import SourceFileMutationData
    from mutmut.mutation.diff_apply import get_diff_for_mutant
    from mutmut.stats import status_by_exit_code
    from mutmut.utils.file_utils import walk_mutatable_files
    from mutmut.utils.format_utils import orig_function_and_class_names_from_key

    for path in sorted(walk_mutatable_files()):
        data = SourceFileMutationData(path=path)
        data.load()
        module = ".".join(path.with_suffix("").parts)
        for name, exit_code in data.exit_code_by_key.items():
            if not fnmatch(name, pattern):
                continue
            state = status_by_exit_code[exit_code]
            method, owner = orig_function_and_class_names_from_key(name)
            function = ".".join(part for part in (module, owner, method) if part)
            known = state in NOTICED or state == UNREACHED
            survivor = None if known else changed_line(function, get_diff_for_mutant(name, path=path))
            yield Result(str(path.parent), function, state, survivor)


def summary(found: Sequence[Result]) -> Iterator[str]:
    """A line a package: how many mutants, and how many in each state."""
    for package in sorted({result.package for result in found}):
        states = Counter(result.state for result in found if result.package == package)
        yield f"{package}: {states.total()} mutants, " + ", ".join(f"{count} {state}" for state, count in sorted(states.items()))


def main(arguments: list[str] | None = None) -> int:
    """Runs mutmut unless told not to, prints counts by package, and returns 1 where results and explanations differ."""
    parser = argparse.ArgumentParser(description="mutation testing against the explained survivors")
    parser.add_argument("--processes", type=int, default=1, help="mutants that are tried at a time")
    parser.add_argument("--only", default="*", help="names of mutants, such as 'ovman.task.*'")
    parser.add_argument("--keep", action="store_true", help="go on with what is in mutants/ from a run of the same code")
    parser.add_argument("--read", action="store_true", help="compare the results in mutants/ and run nothing")
    options = parser.parse_args(arguments)
    os.chdir(ROOT)
    if not options.read:
        if not options.keep:
            shutil.rmtree("mutants", ignore_errors=True)
        names = [] if options.only == "*" else [options.only]
        mutmut = Path(sys.executable).with_name("mutmut")
        if subprocess.run([mutmut, "run", "--max-children", str(options.processes), *names]).returncode:
            return 1
    found = list(results(options.only))
    tried = {result.function for result in found}
    explained = [mutant for mutant in read_explained() if options.only == "*" or mutant.function in tried]
    comparison = compare((result.survivor for result in found if result.survivor), explained)
    print("", *summary(found), f"{len(explained)} survivors are explained in {EXPLAINED.relative_to(ROOT)}", sep="\n")
    for title, mutants in (("without an explanation", comparison.unexplained), ("explained, but no survivor", comparison.stale)):
        for mutant in mutants:
            print(f"\n{title}: {mutant}")
    elsewhere = {name for name in read_elsewhere() if options.only == "*" or name in tried}
    unreached = {result.function for result in found if result.state == UNREACHED}
    for title, names in (("reached by no test", unreached - elsewhere), ("elsewhere, but reached", elsewhere - unreached)):
        for name in sorted(names):
            print(f"\n{title}: {name}")
    return 1 if comparison.unexplained or comparison.stale or unreached != elsewhere else 0


if __name__ == "__main__":
    sys.exit(main())
