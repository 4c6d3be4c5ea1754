"""Properties of the whole project: its dependencies and its version; no file names the machine that made it."""

from __future__ import annotations

import ast
import re
import sys
import tomllib
from importlib import import_module
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest
import yaml
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from packaging.version import Version

import ovman

ROOT = Path(__file__).resolve().parents[1]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PACKAGES = {name: ROOT / "packages" / name for name in ("ovman-client", "ovman-engine", "ovman-released")}
"""Distributions of this repository beside the benchmark itself."""
PROJECTS = {"ovman": PROJECT} | {name: tomllib.loads((path / "pyproject.toml").read_text()) for name, path in PACKAGES.items()}
SAME_MODULE = {"opencv-python-headless": "opencv-python"}
"""The lock has the build of cv2 that needs no window system."""
NOT_INSTALLED = {"onnx": "onnx", "open_clip": "open-clip-torch"} | {
    name: name for name in ("timm", "torch", "torchvision", "ultralytics")
}
"""The distributions of modules that `make setup-dev` does not install."""

SOURCES = ("ovman", "packages", "tests", "bench", "workflow", "overlays", "profiles", "docs", "examples", ".ci")
TEXT = frozenset({".py", ".smk", ".md", ".toml", ".yaml", ".cff", ".lock", ".json", ".jsonl", ".csv", ".tex", ""})


def required(project: str, *extras: str) -> list[Requirement]:
    """What a distribution of this repository requires, with some of its extras."""
    declared = PROJECTS[project]["project"]
    lines = declared["dependencies"] + [line for extra in extras for line in declared["optional-dependencies"][extra]]
    return [Requirement(line) for line in lines]


def extras(project: str) -> list[str]:
    """The names of a distribution's extras."""
    return list(PROJECTS[project]["project"].get("optional-dependencies", {}))


def declared() -> list[tuple[str, Requirement]]:
    """Every requirement of every distribution, but for those on each other."""
    all_of_them = [(p, r) for p in PROJECTS for r in required(p, *extras(p))]
    return [(project, one) for project, one in all_of_them if canonicalize_name(one.name) not in PROJECTS]


LOCKS = ("requirements.lock", "requirements-dev.lock", "requirements-networks.lock")
"""Packages of the benchmark, of lint and tests, and of PyTorch and the long tests."""


def locked(*names: str) -> dict[str, str]:
    """The versions that locks name, of all without `names`."""
    lines = [line for name in names or LOCKS for line in (ROOT / name).read_text().splitlines() if not line.startswith("#")]
    pairs = [line.split("==") for line in lines]
    return {SAME_MODULE.get(canonicalize_name(name), canonicalize_name(name)): version for name, version in pairs}


def files() -> list[Path]:
    """The text files of the project: those at its root and in its folders, not what is made by running it."""
    inside = [path for folder in SOURCES for path in (ROOT / folder).rglob("*")]
    return [
        p
        for p in [*ROOT.iterdir(), *inside]
        if p.is_file() and p.name != ".git" and p.suffix in TEXT and "cache" not in str(p.relative_to(ROOT))
    ]


@pytest.mark.parametrize(("project", "requirement"), declared(), ids=lambda one: str(one))
def test_locked_version_is_in_the_declared_range(project: str, requirement: Requirement) -> None:
    assert requirement.specifier.contains(locked()[canonicalize_name(requirement.name)], prereleases=True)


def test_lock_names_exact_versions_and_no_place_to_fetch_them_from() -> None:
    lines = [line for name in LOCKS for line in (ROOT / name).read_text().splitlines()]
    assert [line for line in lines if not re.fullmatch(r"#[^:/@]*:?|[A-Za-z0-9._-]+==[A-Za-z0-9.!+]+", line)] == []
    assert len(locked()) == sum(not line.startswith("#") for line in lines), "one version of each package, one cv2"


def test_the_benchmark_s_lock_has_what_it_imports_and_no_network_library() -> None:
    """`make tables` installs nothing else."""
    small = locked(LOCKS[0])
    own = [r for p in PROJECTS for r in required(p) if canonicalize_name(r.name) not in PROJECTS]
    assert {canonicalize_name(one.name) for one in own} <= small.keys()
    heavy = {canonicalize_name(r.name) for r in required("ovman", "networks")} - {
        canonicalize_name(r.name) for r in required("ovman")
    }
    assert heavy and not heavy & small.keys() and "statsmodels" not in small and not [n for n in small if n.startswith("nvidia")]


def third_party(path: Path) -> set[str]:
    """Top-level modules that a file imports and that are neither Python's nor the project's."""
    names = set()
    for node in ast.walk(ast.parse(path.read_bytes())):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.add(node.module.partition(".")[0])
    own = {"ovman", "ovman_client", "ovman_engine", "ovman_released", "training", "stage"} | {
        p.stem for p in path.parent.iterdir()
    }
    return names - sys.stdlib_module_names - own


@pytest.mark.parametrize(
    ("folder", "extras", "requires"),
    [
        ("ovman", ("beacon", "dataset", "gym", "networks"), ["ovman"]),
        ("workflow", (), ["ovman"]),
        ("packages/ovman-client/ovman_client", (), ["ovman-client"]),
        ("packages/ovman-engine/ovman_engine", (), ["ovman-engine"]),
        ("packages/ovman-released/ovman_released", (), ["ovman-released", "ovman"]),
    ],
)
def test_what_is_imported_is_declared(folder: str, extras: tuple[str, ...], requires: list[str]) -> None:
    """A contract of import-linter keeps the imports of an extra in one room."""
    allowed = {canonicalize_name(requirement.name) for project in requires for requirement in required(project, *extras)}
    distributions = {name: [distribution] for name, distribution in NOT_INSTALLED.items()} | packages_distributions()
    undeclared = {
        (str(path.relative_to(ROOT)), module)
        for path in sorted((ROOT / folder).rglob("*.py"))
        for module in third_party(path)
        if not allowed & {SAME_MODULE.get(d, d) for d in map(canonicalize_name, distributions.get(module, []))}
    }
    assert undeclared == set()


def test_every_file_of_the_package_is_installed_with_it() -> None:
    (patterns,) = PROJECT["tool"]["setuptools"]["package-data"].values()
    package = ROOT / "ovman"
    installed = {path for pattern in patterns for path in package.glob(pattern)} | set(package.rglob("*.py"))
    left = {path for path in package.rglob("*") if path.is_file() and "cache" not in str(path.relative_to(ROOT))} - installed
    assert left == set()


def test_one_version() -> None:
    version = ovman.__version__
    assert Version(version)
    assert yaml.safe_load((ROOT / "CITATION.cff").read_text())["version"] == version
    assert re.search(r"^## (\S+)$", (ROOT / "CHANGELOG.md").read_text(), re.MULTILINE)[1] == version
    assert PROJECT["tool"]["setuptools"]["dynamic"]["version"]["attr"] == "ovman.__version__"


@pytest.mark.parametrize("name", sorted(PROJECT["project"]["scripts"]))
def test_commands_exist(name: str) -> None:
    module, _, function = PROJECT["project"]["scripts"][name].partition(":")
    assert callable(getattr(import_module(module), function))


def test_no_file_names_a_place_of_one_machine() -> None:
    place = re.compile(r"(?<![\w.~*$}-])/(?:work|root|home|Users|tmp|mnt|opt)/[\w.]")
    found = [
        f"{path.relative_to(ROOT)}:{number}: {line.strip()}"
        for path in files()
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if place.search(line)
    ]
    assert found == []


def test_all_that_the_snakefile_imports_is_known_to_start_fast() -> None:
    (contract,) = (c for c in PROJECT["tool"]["importlinter"]["contracts"] if "Snakefile" in c["name"])
    files = [ROOT / "Snakefile", *(ROOT / "workflow" / "rules").iterdir()]
    imported = {name for path in files for name in re.findall(r"^from (ovman\S*) import", path.read_text(), re.MULTILINE)}
    assert imported and imported <= set(contract["source_modules"])
