"""Copy the pages of the site into build/docs, where Zensical reads them: `make site`.

The folders stay as they are, so that relative links stay. Every file that a page links to is copied too: a text file becomes a
page that shows it, a notebook a page of its cells, and a folder without a README a page of its tables. The pages about the
program are made from the program.
"""

from __future__ import annotations

import inspect
import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

from cyclopts.docs.markdown import generate_markdown_docs
from pydantic import BaseModel

from ovman.cli.commands import app
from ovman.records.draw import Draw
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Rollout, Score
from ovman.records.scene import Scene
from ovman.records.visit import Visit

ROOT = Path(__file__).resolve().parents[1]
PAGES = "README.md", "config/README.md", "docs/**/*.md", "docs/*.ipynb"
LINK = re.compile(r"(?<=\]\()([^)\s#:]+)(?=[)#])|(?<=src=\")([^\"#:]+)(?=\")")
PICTURES = (".png", ".jpg", ".gif", ".svg", ".webp")
INTERFACE = {
    "ovman.agents.interface": "Agent AgentContext Visit Observation CameraPose Query Relation Action PredictionContext Answer"
    " Abstention AbstentionReason",
    "ovman.agents.pilot": "Pilot",
    "ovman.perception.clusters": "Cluster ObjectMap",
    "ovman.perception.backprojection": "Camera median_point",
}
"""Names that the page of the agent interface shows, by module."""
RECORDS = Episode, Scene, Visit, Prediction, Rollout, Score, Draw
"""Records that files hold; the page shows those that they consist of, too."""


def stage(folder: Path) -> None:
    """Write all pages, and the files that they link to, into a folder that is emptied first."""
    shutil.rmtree(folder, ignore_errors=True)
    left, done = [path for pattern in PAGES for path in sorted(ROOT.glob(pattern))], set[Path]()
    while left:
        if (path := left.pop()) in done:
            continue
        done.add(path)
        target = folder / page_of(path).relative_to(ROOT)
        target.parent.mkdir(parents=True, exist_ok=True)
        if path.suffix in PICTURES:
            shutil.copy2(path, target)
        else:
            links: list[Path] = []
            target.write_text(rewrite_links(read_page(path), path, links), encoding="utf-8")
            left += links
    reference = folder / "docs" / "reference"
    reference.mkdir()
    commands = generate_markdown_docs(app, generate_toc=False, exclude_commands=["--install-completion"])
    shown = (f"::: {module}.{name}" for module, names in INTERFACE.items() for name in names.split())
    (reference / "cli.md").write_text(commands.replace("# ovman\n", "# Command line\n", 1), encoding="utf-8")
    (reference / "agent.md").write_text("\n\n".join(["# Agent interface", *shown, ""]), encoding="utf-8")
    (reference / "records.md").write_text("\n\n".join(["# Records", *describe_records(), ""]), encoding="utf-8")


def describe_records() -> Iterator[str]:
    """Yield what the page of records shows: of each class its docstring and a table of its fields."""
    yield (
        "A file of records has one JSON object per line. A class below is an object, and a row of its table a key. `Text`, `Name`"
        " and `InstanceId` are strings, `Point` is [x, z] in metres, `Length` is a number of metres, and `Count` an integer."
    )
    left, done = [*RECORDS], set[type[BaseModel]]()
    while left:
        record = left.pop(0)
        left += [one for field in record.model_fields.values() for one in records_in(field.annotation)]
        named = record.__pydantic_generic_metadata__["origin"] or record
        if named in done:
            continue
        done.add(named)
        written = {name: kind for base in reversed(named.__mro__) for name, kind in inspect.get_annotations(base).items()}
        rows = ["| key | type | |", "|---|---|---|"]
        for name, field in named.model_fields.items():
            presence = "optional" if not field.is_required() and name != "schema_id" else ""
            rows.append(f"| `{field.alias or name}` | `{written[name]}` | {presence} |".replace(" | None", " or None"))
        yield f"## {named.__name__}\n\n{inspect.getdoc(named)}\n\n" + "\n".join(rows)


def records_in(kind: Any) -> list[type[BaseModel]]:
    """Return the classes of records in an annotation."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return [kind]
    return [one for part in get_args(kind) for one in records_in(part)]


def page_of(path: Path) -> Path:
    """Return where the page that shows a file or folder lies."""
    if path.is_dir():
        return path / "README.md"
    if path.suffix in (".md", *PICTURES):
        return path
    return path.with_suffix(".md") if path.suffix == ".ipynb" else path.with_name(f"{path.name}.md")


def rewrite_links(text: str, path: Path, found: list[Path]) -> str:
    """Return a page with links to pages in place of files and folders; append what it links to."""
    folder = path if path.is_dir() else path.parent

    def rewrite(match: re.Match[str]) -> str:
        target = Path(os.path.normpath(folder / match[0]))
        if not target.exists() or ROOT not in target.parents:
            return match[0]
        if (target / "README.md").is_file():
            target /= "README.md"
        found.append(target)
        return os.path.relpath(page_of(target), folder)

    return LINK.sub(rewrite, text)


def read_page(path: Path) -> str:
    """Return the Markdown that shows a file or folder."""
    if path.is_dir():
        shown = sorted(one for one in path.iterdir() if one.suffix in (".md", ".yaml"))
        return "\n\n".join([f"# {path.name.capitalize()}", *(f"## {one.stem}\n\n{read_page(one)}" for one in shown)])
    text = path.read_text(encoding="utf-8")
    if path.suffix == ".md":
        return text
    if path.suffix == ".ipynb":
        return "\n\n".join(show_cell(cell) for cell in json.loads(text)["cells"])
    return f"# {path.name}\n\n```{path.suffix.removeprefix('.')}\n{text}```\n"


def show_cell(cell: dict) -> str:
    """Return a cell of a notebook as Markdown: commands as in a terminal, files with their name, printed output below."""
    source = "".join(cell["source"])
    if cell["cell_type"] == "markdown":
        return source
    if source.startswith("%%writefile "):
        name, _, source = source.removeprefix("%%writefile ").partition("\n")
        block = f'```python title="{name}"\n{source}\n```'
    elif source.startswith("!"):
        block = f"```console\n{re.sub('^!', '$ ', source, flags=re.MULTILINE)}\n```"
    else:
        block = f"```python\n{source}\n```"
    printed = "".join(line for output in cell["outputs"] for line in output.get("text", ()))
    pictures = [data["image/jpeg"] for data in (output.get("data", {}) for output in cell["outputs"]) if "image/jpeg" in data]
    shown = [f"```text\n{printed.rstrip()}\n```"] * bool(printed)
    shown += [f"![Output of the cell](data:image/jpeg;base64,{picture.strip()})" for picture in pictures]
    return "\n\n".join([block, *shown])


if __name__ == "__main__":
    stage(ROOT / "build" / "docs")
