"""Links, commands, make targets and paths in the documents exist."""

from __future__ import annotations

import re
import runpy
import subprocess
from functools import cache
from pathlib import Path

import pytest
import yaml

from ovman.cli import main

ROOT = Path(__file__).parents[1]
AT_ROOT = "README.md", "AGENTS.md", "CONTRIBUTING.md", "CODE_OF_CONDUCT.md"
PATTERNS = *AT_ROOT, "config/*.md", "docs/**/*.md", "packages/*/README.md", "packages/*/docs/*.md", "models/README.md"
PAGES = [path for pattern in PATTERNS for path in sorted(ROOT.glob(pattern))]


def code(page: Path) -> str:
    """Return the code of a page: blocks, indented commands and words in backticks."""
    text = page.read_text(encoding="utf-8").replace("\\\n", " ")
    blocks = re.findall(r"```(?:sh|console|bash)\n(.*?)```", text, re.DOTALL)
    return "\n".join([*blocks, *re.findall(r"^    (\S.*)$", text, re.MULTILINE), *re.findall(r"`([^`\n]+)`", text)])


@cache
def help_text(command: str) -> str:
    """Return the help of a subcommand of `ovman`."""
    from contextlib import redirect_stdout
    from io import StringIO

    with redirect_stdout(StringIO()) as said:
        assert main([command, "--help"]) == 0, command
    return said.getvalue()


def anchors(page: Path) -> set[str]:
    """Return the anchors that GitHub gives the headings of a page."""
    heads = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).strip().replace(" ", "-") for head in heads}


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_links_resolve(page: Path) -> None:
    text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    for link in re.findall(r"\]\(([^)\s]+)\)", text):
        path, _, anchor = link.partition("#")
        if re.match(r"https?:|mailto:", link):
            continue
        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors(target), link


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_commands_exist(page: Path) -> None:
    targets = set(re.findall(r"^([a-z-]+):", (ROOT / "Makefile").read_text(), re.MULTILINE))
    for line in code(page).splitlines():
        line = line.split(" # ")[0].strip("$ ")
        if made := re.fullmatch(r"make ([a-z-]+)(?: .*)?", line):
            assert made[1] in targets, line
        if line.startswith("snakemake "):
            assert re.search(r" (--cores|--profile|-n) ", line), f"{line}: Snakemake needs a number of cores"
        if asked := re.fullmatch(r"ovman ([a-z]+)\b(.*)", line):
            for option in re.findall(r"(?<!\S)(--[a-z-]+)", asked[2]):
                assert re.search(rf"{option}\b", help_text(asked[1])), line


def test_diffs_apply() -> None:
    diffs = re.findall(r"```diff\n(.*?)```", (ROOT / "docs" / "extending.md").read_text(), re.DOTALL)
    assert len(diffs) > 4
    for diff in diffs:
        done = subprocess.run(["git", "apply", "--check", "--unidiff-zero"], cwd=ROOT, input=diff, text=True, capture_output=True)
        assert done.returncode == 0, f"{diff}\n{done.stderr}"


@pytest.mark.parametrize(
    "page", [page for page in PAGES if page.parent.name in ("docs", "decisions")], ids=lambda page: page.stem
)
def test_paths_exist(page: Path) -> None:
    for word in re.findall(r"`([\w./-]+)`", page.read_text(encoding="utf-8")):
        if re.match(r"(ovman|workflow|config|overlays|profiles|packages|examples|training|tests|data|models)/", word):
            assert (ROOT / word).exists() or (page.parents[1] / word).exists(), word


@pytest.fixture(scope="module")
def staged(tmp_path_factory):
    """The folder of the pages that Zensical gets."""
    folder = tmp_path_factory.mktemp("site")
    runpy.run_path(str(ROOT / "docs" / "stage.py"))["stage"](folder)
    return folder


def navigation() -> set[str]:
    """Return the pages that the navigation of the site names."""

    class Loader(yaml.SafeLoader):
        """Reads the tags of mkdocs.yml as nothing."""

    Loader.add_multi_constructor("", lambda *_: None)
    left, found = [yaml.load((ROOT / "mkdocs.yml").read_text(), Loader)["nav"]], set()
    while left:
        match left.pop():
            case dict(one):
                left += one.values()
            case list(one):
                left += one
            case page:
                found.add(page)
    return found


def test_the_navigation_of_the_site_has_every_page(staged):
    assert [page for page in navigation() if not (staged / page).is_file()] == []
    pages = {page.with_suffix(".md").name for pattern in ("*.md", "*.ipynb") for page in (ROOT / "docs").glob(pattern)}
    assert {f"docs/{name}" for name in pages} <= navigation()


def test_every_decision_is_listed():
    folder = ROOT / "docs" / "decisions"
    listed = set(re.findall(r"\]\((\S+)\)", (folder / "README.md").read_text()))
    assert {page.name for page in folder.glob("0*.md")} == listed


def test_every_command_and_record_has_its_place_in_the_reference(staged):
    reference = staged / "docs" / "reference"
    commands, records = ((reference / f"{name}.md").read_text() for name in ("cli", "records"))
    assert "## ovman eval" in commands and "`--agent" in commands
    assert "## Episode" in records and "| `shortest_path_m` |" in records


def test_pages_of_the_site_link_to_files_of_the_site(staged):
    for page in staged.rglob("*.md"):
        text = re.sub(r"```.*?```", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
        for link in re.findall(r"\]\(([^)\s#:]+)(?:#[^)]*)?\)", text):
            assert (page.parent / link).is_file(), (page, link)
