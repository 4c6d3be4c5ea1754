"""Properties of the whole project: its dependencies and its version; no file names the machine that made it."""

from __future__ import annotations

import ast
import json
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
"""uv installs the build of cv2 that needs no window system."""
NOT_INSTALLED = {"onnx": "onnx", "open_clip": "open-clip-torch"} | {
    name: name for name in ("timm", "torch", "torchvision", "ultralytics")
}
"""The distributions of modules that `make setup-dev` does not install."""

SOURCES = ("ovman", "packages", "tests", "bench", "workflow", "overlays", "profiles", "docs", "examples", ".ci")
TEXT = frozenset({".py", ".smk", ".md", ".toml", ".yaml", ".cff", ".lock", ".json", ".jsonl", ".csv", ".tex", ""})


def required(project: str, *extras: str) -> list[Requirement]:
    """What a distribution of this repository requires, with some of its extras."""
    declared = PROJECTS[project]["project"]
    optional = declared.get("optional-dependencies", {}) | PROJECTS[project].get("dependency-groups", {})
    lines = declared["dependencies"] + [line for extra in extras for line in optional[extra]]
    return [Requirement(line) for line in lines]


def extras(project: str) -> list[str]:
    """The names of a distribution's extras and groups."""
    return [*PROJECTS[project]["project"].get("optional-dependencies", {}), *PROJECTS[project].get("dependency-groups", {})]


def declared() -> list[tuple[str, Requirement]]:
    """Every requirement of every distribution, but for those on each other."""
    all_of_them = [(p, r) for p in PROJECTS for r in required(p, *extras(p))]
    return [(project, one) for project, one in all_of_them if canonicalize_name(one.name) not in PROJECTS]


LOCK = {one["name"]: one for one in tomllib.loads((ROOT / "uv.lock").read_text())["package"]}
"""The packages of uv.lock by name."""
HOSTS = ("https://pypi.org/", "https://files.pythonhosted.org/")


def installed(*extras: str) -> set[str]:
    """The packages that uv installs for all distributions of this repository, with some extras of ovman."""
    found, left = set(), [*PROJECTS, *(one["name"] for extra in extras for one in LOCK["ovman"]["optional-dependencies"][extra])]
    while left:
        if (name := left.pop()) not in found:
            found.add(name)
            left += [one["name"] for one in LOCK[name].get("dependencies", [])]
    return found


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
    name = canonicalize_name(requirement.name)
    version = LOCK[next((headless for headless, window in SAME_MODULE.items() if window == name), name)]["version"]
    assert requirement.specifier.contains(version, prereleases=True)


def test_lock_has_a_hash_of_every_file_and_names_public_places_alone() -> None:
    text = (ROOT / "uv.lock").read_text()
    assert [url for url in re.findall(r'"(\w+://[^"]*)"', text) if not url.startswith(HOSTS)] == []
    files = [file for one in LOCK.values() for file in [*one.get("wheels", []), *([one["sdist"]] if "sdist" in one else [])]]
    assert len(files) > len(LOCK) and all(file["hash"].startswith("sha256:") for file in files)
    assert "opencv-python" not in LOCK, "one cv2"


def test_the_benchmark_installs_no_network_library() -> None:
    """`make tables` installs no group and no extra."""
    small = installed()
    assert "numpy" in small and not {"torch", "statsmodels", "pytest"} & small
    assert "torch" in installed("networks") and not [name for name in small if name.startswith("nvidia")]


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


def test_citation_and_archive_describe_one_work() -> None:
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    archived = json.loads((ROOT / ".zenodo.json").read_text())
    for key in ("title", "license", "keywords"):
        assert archived[key] == cited[key], key
    assert archived["creators"] == cited["authors"]


def test_every_dependency_of_the_package_has_a_reason() -> None:
    rows = re.findall(r"^\| (`.*?) \| \S", (ROOT / "CONTRIBUTING.md").read_text(), re.MULTILINE)
    reasoned = {name for row in rows for name in re.findall(r"`([\w-]+)`", row)}
    assert {requirement.name for requirement in required("ovman")} <= reasoned


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
