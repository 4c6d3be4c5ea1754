"""The leaderboard: what agrees stands in its block and order, what does not is refused with its reason, and others stand."""

from __future__ import annotations

import gzip
import json
import shutil

import pytest
import yaml

from tests.entry.evaluations import DEPTH, ORACLE, SCENE, command
from tests.episodes import of_scene

ABOUT = ["--author", "A. Author", "--about", "What it is."]
SPLIT = "dev"


@pytest.fixture(scope="module")
def release(tmp_path_factory):
    """A release whose split has two episodes."""
    directory = tmp_path_factory.mktemp("release")
    (directory / "episodes").mkdir()
    (directory / "episodes" / f"{SPLIT}.jsonl").write_text("".join(one.to_line() for one in of_scene(SCENE)))
    return directory


@pytest.fixture(scope="module")
def evaluations(tmp_path_factory, release, tours):
    """Whole evaluations of a control and of the oracle."""
    made = {}
    for arm in (DEPTH, ORACLE):
        made[arm] = tmp_path_factory.mktemp("evaluation") / "out"
        options = ["--arm", arm, "--split", SPLIT, "--release", release, "--cache", tours, "--out", made[arm]]
        assert command("eval", *options) == 0
    return made


@pytest.fixture
def enter(release, tmp_path):
    """Enters something into a leaderboard of the test's own."""
    return lambda *options: command("enter", *options, "--release", release, "--leaderboard", tmp_path / "board")


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """The folder in which the command keeps what it drives again."""
    return tmp_path_factory.mktemp("driven")


@pytest.fixture
def board(release, tmp_path, driven):
    """Makes the pages, and returns the exit status."""
    return lambda: command("leaderboard", tmp_path / "board", "--release", release, "--cache", driven)


def points(path, found):
    """A file of points, of which the first `found` are answers."""
    there = of_scene(SCENE)
    lines = [
        {"episode": one.id, "x": one.answer[0] + (0 if number < found else 9), "z": one.answer[1]}
        for number, one in enumerate(there)
    ]
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return path


def test_entries_stand_by_split_and_role(evaluations, enter, board, tmp_path, capsys):
    assert enter(evaluations[DEPTH], "depth", "--system", "depth <difference>", "--role", "control", *ABOUT) == 0
    assert enter(evaluations[ORACLE], "oracle", "--system", "oracle check", "--role", "diagnostic", *ABOUT) == 0
    assert enter(points(tmp_path / "half.jsonl", 1), "half", "--split", SPLIT, "--system", "half", *ABOUT) == 0
    assert enter(points(tmp_path / "all.jsonl", 2), "all", "--split", SPLIT, "--system", "all", *ABOUT) == 0
    assert board() == 0
    text = (tmp_path / "board" / "README.md").read_text()
    order = [
        "dev, driving",
        "*controls*",
        "depth <difference>",
        "*diagnostics*",
        "oracle check",
        "dev, static gate",
        "[all]",
        "[half]",
    ]
    places = [text.index(name) for name in order]
    assert places == sorted(places)
    assert "Refused" not in text
    (all_, half) = (next(line for line in text.splitlines() if f"[{name}]" in line) for name in ("all", "half"))
    assert all_.startswith("| 1. ") and "1.000" in all_ and half.startswith("| 2. ") and "0.500" in half
    page = (tmp_path / "board" / "index.html").read_text()
    assert "depth &lt;difference&gt;" in page and "<script" not in page
    capsys.readouterr()
    assert board() == 0
    assert "left" not in capsys.readouterr().out.replace(" 0:00:00 left", "")
    assert (tmp_path / "board" / "README.md").read_text() == text


def test_an_evaluation_can_be_added_to_an_entry(evaluations, enter, board, tmp_path, capsys):
    assert enter(points(tmp_path / "all.jsonl", 2), "mine", "--split", SPLIT, "--system", "mine", *ABOUT) == 0
    said = capsys.readouterr()
    assert said.out == f"{tmp_path / 'board' / 'mine' / SPLIT}\n"
    assert f"{SPLIT} is a split for tuning" in said.err and "pull request" in said.err
    assert enter(evaluations[DEPTH], "mine") == 0
    assert {path.name for path in (tmp_path / "board" / "mine" / SPLIT).iterdir()} == {
        "manifest.json",
        "predictions.jsonl",
        "runs.jsonl.gz",
    }
    assert enter(evaluations[DEPTH], "mine") == 1
    assert "is there already" in capsys.readouterr().err
    assert board() == 0


def test_a_changed_run_is_refused_and_the_others_stand(evaluations, enter, board, tmp_path, capsys):
    assert enter(evaluations[DEPTH], "good", "--system", "good", *ABOUT) == 0
    assert enter(evaluations[DEPTH], "bad", "--system", "bad", *ABOUT) == 0
    path = tmp_path / "board" / "bad" / SPLIT / "runs.jsonl.gz"
    runs = [json.loads(line) for line in gzip.decompress(path.read_bytes()).splitlines()]
    runs[0]["success"] = not runs[0]["success"]
    path.write_bytes(gzip.compress("".join(json.dumps(run, separators=(",", ":")) + "\n" for run in runs).encode()))
    capsys.readouterr()
    assert board() == 1
    text = (tmp_path / "board" / "README.md").read_text()
    assert "## Refused" in text and f"`bad/{SPLIT}`" in text and "success: " in text
    assert "[good](good)" in text and "[bad](bad)" not in text
    assert f"refused: bad/{SPLIT}: " in capsys.readouterr().out


def relabelled(source, to, **values):
    """A copy of an evaluation with another manifest."""
    shutil.copytree(source, to)
    manifest = json.loads((to / "manifest.json").read_text()) | values
    (to / "manifest.json").write_text(json.dumps(manifest, separators=(",", ":")) + "\n")
    return to


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"asked": [of_scene(SCENE)[0].id]}, "asked: 1 of 2 episodes; run them all"),
        ({"seeds": [0]}, "seeds: [0]; run it under [0, 1, 2]"),
        ({"budget": 1000}, "budget: 1000 actions"),
        ({"handed": ["answer"]}, "entered as diagnostic"),
        ({"split": None}, "split: "),
    ],
)
def test_what_is_no_entry_is_refused_before_it_is_one(evaluations, enter, tmp_path, capsys, values, said):
    source = relabelled(evaluations[DEPTH], tmp_path / "source", **values)
    assert enter(source, "mine", "--system", "mine", *ABOUT) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line and not (tmp_path / "board").exists()


def test_what_was_put_there_by_hand_is_refused_alike(evaluations, board, tmp_path):
    relabelled(evaluations[ORACLE], tmp_path / "board" / "mine" / SPLIT, seeds=[0])
    entry = {"system": "mine", "role": "system", "authors": ["A"], "date": "2026-01-01", "code": None, "about": "x"}
    (tmp_path / "board" / "mine" / "entry.yaml").write_text(yaml.safe_dump(entry))
    assert board() == 1
    text = (tmp_path / "board" / "README.md").read_text()
    assert "seeds: [0]; run it under [0, 1, 2]" in text and "handed: grounding, positions, answer" in text


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda entry: entry.pop("about"), "about: "),
        (lambda entry: entry.update(abuot="x"), "abuot"),
        (lambda entry: entry.update(role="winner"), "role: "),
        (lambda entry: entry.update(code="javascript:alert(1)"), "code: "),
        (lambda entry: entry.update(authors=[]), "authors: "),
        (lambda entry: entry.update(date="yesterday"), "date: "),
    ],
)
def test_a_wrong_entry_is_one_line(board, tmp_path, capsys, change, said):
    folder = tmp_path / "board" / "mine" / SPLIT
    folder.mkdir(parents=True)
    points(folder / "predictions.jsonl", 2)
    entry = {"system": "mine", "role": "system", "authors": ["A"], "date": "2026-01-01", "code": None, "about": "x"}
    change(entry)
    (tmp_path / "board" / "mine" / "entry.yaml").write_text(yaml.safe_dump(entry))
    assert board() == 1
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("refused: ")]
    assert "entry.yaml" in line and said in line


def test_an_entry_cannot_lie_elsewhere(enter, tmp_path, capsys):
    for name in ("../mine", "Mine", "", "a/b", "."):
        assert enter(points(tmp_path / "all.jsonl", 2), name, "--split", SPLIT, "--system", "mine", *ABOUT) == 1
        assert "is no name of an entry" in capsys.readouterr().err
