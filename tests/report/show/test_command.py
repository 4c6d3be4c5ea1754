from __future__ import annotations

import pytest

from ovman import cli
from ovman.task import Relation
from tests.report.show.conftest import ROOT, SCENE
from tests.report.show.html_reader import Page

CONFIG = ["--config", str(ROOT / "config.yaml")]


def test_one_episode_is_one_file(made, tmp_path, capsys):
    output = tmp_path / "deep" / "page.html"
    assert cli.main(["show", f"{SCENE}/moved/0000", "--results", str(made), "--output", str(output), *CONFIG]) == 0
    assert capsys.readouterr().out == f"{output}\n"
    assert Page(output.read_text(encoding="utf-8")).all("h1")[0].text == "“go to the chair of moved”"


def test_many_episodes_have_an_index_that_leads_to_them(made, tmp_path):
    assert cli.main(["show", "--all", "--results", str(made), "--output", str(tmp_path), *CONFIG]) == 0
    index = Page((tmp_path / "index.html").read_text(encoding="utf-8"))
    links = [e.attributes["href"] for e in index.all("a")]
    assert links == [f"{SCENE}/{relation}/0000.html" for relation in Relation]
    for link in links:
        assert link.removesuffix(".html") in (tmp_path / link).read_text(encoding="utf-8")


def test_a_pattern_names_several(made, tmp_path):
    pattern = f"{SCENE}/mov*/*"
    assert cli.main(["show", pattern, "--results", str(made), "--output", str(tmp_path), *CONFIG]) == 0
    assert sorted(path.parent.name for path in tmp_path.rglob("0000.html")) == ["moved", "moving"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["FloorPlan1/moved/0001"], f"no such episode: FloorPlan1/moved/0001; the nearest is {SCENE}/moved/0000"),
        (["FloorPlan2*"], "no such episode"),
        ([], "or write --all"),
        (["--results", "nowhere", "--all"], "make tables"),
        (["--all", "--config", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_what_cannot_be_shown_is_said_in_one_line(made, capsys, arguments, words):
    given = [*arguments, *([] if "--results" in arguments else ["--results", str(made)])]
    given += [] if "--config" in arguments else CONFIG
    assert cli.main(["show", *given]) == 1
    said = capsys.readouterr()
    assert words in said.err and said.err.count("\n") == 1 and said.out == ""


def test_a_missing_scene_is_named(made, tmp_path, capsys):
    (tmp_path / "episodes").mkdir()
    (tmp_path / "episodes" / "main.jsonl").write_text((made / "episodes" / "main.jsonl").read_text())
    assert cli.main(["show", f"{SCENE}/moved/0000", "--results", str(tmp_path), *CONFIG]) == 1
    assert f"{SCENE}.json is missing; make it with `make tables`" in capsys.readouterr().err
