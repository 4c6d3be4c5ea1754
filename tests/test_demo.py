"""`ovman demo`: a home, an episode in it, two agents and a page."""

from __future__ import annotations

import json
from collections import Counter

import pytest

from ovman.cli import main
from ovman.demo import AGENTS, DRAW, PAGE
from ovman.records.draw import EPISODES
from ovman.records.episode import Episode
from ovman.sim.scenes import load_scene

SEED = 2


@pytest.fixture(scope="module")
def shown(tmp_path_factory):
    """The folder of a demo, and what it printed as JSON."""
    out = tmp_path_factory.mktemp("demo") / "out"
    with pytest.MonkeyPatch.context() as patch:
        told = []
        patch.setattr("ovman.cli.console.print_json", told.append)
        assert main(["demo", "--seed", str(SEED), "--out", str(out), "--json"]) == 0
    return out, told[0]


def test_both_agents_answer_every_question_about_a_new_home(shown):
    out, told = shown
    episodes = Episode.load(out / DRAW / EPISODES)
    questions = [episode.sentence for episode in episodes]
    assert len({episode.pair for episode in episodes}) == 1 and episodes[0].pair is not None
    assert all(number > 1 for key in ("category", "relation") for number in Counter(getattr(e, key) for e in episodes).values())
    assert len(load_scene(episodes[0].scene)["rooms"]) == 1
    assert sorted(row["question"] for row in told["runs"]) == sorted(questions * len(AGENTS))
    assert {row["result"] for row in told["runs"]} <= {"success", "failure"}
    json.dumps(told)


def test_the_page_stands_alone_and_has_both_visits_answers_and_paths(shown):
    out, told = shown
    page = (out / PAGE).read_text(encoding="utf-8")
    assert told["page"] == str(out / PAGE) and told["seed"] == SEED and f"seed {SEED}" in page
    assert any(row["question"] in page for row in told["runs"])
    assert page.count("data:image/jpeg") >= 24 and "http" not in page.replace("http://www.w3.org", "")
    for number in range(len(AGENTS)):
        assert f"arm-own-{number}" in page


def test_a_folder_in_use_is_refused_before_anything_is_drawn(shown, capsys):
    out, _ = shown
    assert main(["demo", "--seed", str(SEED), "--out", str(out)]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert str(out) in line and "name a new folder" in line
