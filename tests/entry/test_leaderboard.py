"""The leaderboard: what agrees stands in its block and order, what does not is refused with its reason, and others stand."""

from __future__ import annotations

import gzip
import json
import re
import shutil

import pytest
import yaml

from ovman.cache import Cache
from ovman.entry.manifest import read_manifest
from ovman.entry.verification import replay_job, replay_key
from ovman.provenance import ENGINE, digest_code
from ovman.records.run import Score
from ovman.settings.settings_files import read_merged, with_parts
from ovman.shipped import HOME
from tests.arms import CONFIG
from tests.entry.evaluations import ASKED, DEPTH, ORACLE, SCENE, command
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
def options(release):
    """The options of the commands: that release, and settings that ask for one seed."""
    settings, config = read_merged(with_parts(HOME / "config.yaml")), release / "config.yaml"
    settings["evaluation"]["seeds"] = [0]
    config.write_text(yaml.safe_dump(settings, sort_keys=False))
    return "--release", release, "--config", config


@pytest.fixture(scope="module")
def evaluations(tmp_path_factory, options, tours):
    """Whole evaluations of a control and of the oracle."""
    made = {}
    for arm in (DEPTH, ORACLE):
        made[arm] = tmp_path_factory.mktemp("evaluation") / "out"
        assert command("eval", "--arm", arm, "--split", SPLIT, "--cache", tours, "--out", made[arm], *options) == 0
    return made


@pytest.fixture
def enter(options, tmp_path):
    """Enters something into a leaderboard of the test's own."""
    return lambda *given: command("enter", *given, *options, "--leaderboard", tmp_path / "board")


@pytest.fixture(scope="module")
def driven(tmp_path_factory):
    """The folder in which the command keeps what it drives again."""
    return tmp_path_factory.mktemp("driven")


@pytest.fixture
def board(options, tmp_path, driven):
    """Makes the pages, and returns the exit status."""
    return lambda: command("leaderboard", tmp_path / "board", *options, "--cache", driven)


def points(path, found):
    """A file of points, of which the first `found` are answers."""
    points = [(one.id, one.answer[0] + (0 if number < found else 9), one.answer[1]) for number, one in enumerate(of_scene(SCENE))]
    path.write_text("".join(json.dumps({"episode": episode, "x": x, "z": z}) + "\n" for episode, x, z in points))
    return path


def test_entries_stand_by_split_and_role(evaluations, enter, board, tmp_path, capsys):
    assert enter(evaluations[DEPTH], "depth", "--system", "depth <difference>", "--role", "control", *ABOUT) == 0
    assert enter(evaluations[ORACLE], "oracle", "--system", "oracle check", "--role", "diagnostic", *ABOUT) == 0
    assert enter(points(tmp_path / "half.jsonl", 1), "half", "--split", SPLIT, "--system", "half", *ABOUT) == 0
    assert enter(points(tmp_path / "all.jsonl", ASKED), "all", "--split", SPLIT, "--system", "all", *ABOUT) == 0
    assert board() == 0
    text = (tmp_path / "board" / "README.md").read_text()
    blocks = ["dev, driving", "*controls*", r"depth \<difference\>", "*diagnostics*", "oracle check", "dev, static gate"]
    places = [text.index(name) for name in (*blocks, "[all]", "[half]")]
    assert places == sorted(places)
    assert "Refused" not in text
    (all_, half) = (next(line for line in text.splitlines() if f"[{name}]" in line) for name in ("all", "half"))
    assert "1.000" in all_ and f"{1 / ASKED:.3f}" in half and "1. [" not in text
    capsys.readouterr()
    assert board() == 0
    assert "left" not in capsys.readouterr().out.replace(" 0:00:00 left", "")
    assert (tmp_path / "board" / "README.md").read_text() == text


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
        ({"asked": [of_scene(SCENE)[0].id]}, f"asked: 1 of {ASKED} episodes; run them all"),
        ({"seeds": [1]}, "seeds: [1]; run it under [0]"),
        ({"budget": 1000}, "budget: 1000 actions"),
        ({"handed": ["answer"]}, "entered as diagnostic"),
        ({"budget": -5}, "manifest.json:1: budget: "),
        ({"seeds": [-1]}, "manifest.json:1: seeds[0]: "),
        ({"arm": "depth\nall runs agree"}, "manifest.json:1: arm: "),
        ({"needs": ["\x1b[2J"]}, "manifest.json:1: needs[0]: "),
        ({"split": None}, "split: "),
        ({"split": "../../elsewhere"}, "manifest.json:1: split: "),
        ({"split": "elsewhere"}, "elsewhere is no split"),
    ],
)
def test_what_is_no_entry_is_refused_before_it_is_one(evaluations, enter, tmp_path, capsys, values, said):
    source = relabelled(evaluations[DEPTH], tmp_path / "source", **values)
    assert enter(source, "mine", "--system", "mine", *ABOUT) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line and not (tmp_path / "board").exists()


def test_the_first_attempt_counts(evaluations, enter, board, tmp_path, capsys):
    """A run of two attempts is driven again like others, and has failed; entries that count none are as they were."""
    run = {"episode": of_scene(SCENE)[0].id, "seed": 0, "attempts": 2}
    source = relabelled(evaluations[ORACLE], tmp_path / "source", repeated=[run])
    (source / "summary.json").unlink()
    older = relabelled(evaluations[ORACLE], tmp_path / "older")
    manifest = json.loads((older / "manifest.json").read_text())
    assert manifest.pop("repeated") == []
    (older / "manifest.json").write_text(json.dumps(manifest) + "\n")
    for name, folder in (("again", source), ("older", older)):
        assert enter(folder, name, "--system", name, "--role", "diagnostic", *ABOUT) == 0
    assert board() == 0
    text = (tmp_path / "board" / "README.md").read_text().splitlines()
    again, once = (next(line for line in text if f"[{name}]" in line) for name in ("again", "older"))
    assert f"| {1 - 1 / ASKED:.3f} |" in again and "runs failed at the first attempt: 1" in again
    assert "| 1.000 |" in once and "attempt" not in once


def by_hand(board_folder, name, **values):
    """An entry of right points that nobody has checked, as a pull request brings it."""
    folder = board_folder / name / SPLIT
    folder.mkdir(parents=True)
    points(folder / "predictions.jsonl", 2)
    entry = {"system": name, "role": "system", "authors": ["A"], "date": "2026-01-01", "code": None, "about": "x"} | values
    (folder.parent / "entry.yaml").write_text(yaml.safe_dump(entry))
    return folder.parent


def refusals(capsys):
    """The lines in which the command refuses entries."""
    return [line for line in capsys.readouterr().out.splitlines() if line.startswith("refused: ")]


BOMB = "\n".join(["a0: &a0 x", *(f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]" for n in range(1, 7))])
"""YAML of 9 to the power of 6 values."""


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"abuot": "x"}, "abuot"),
        ({"role": "winner"}, "role: "),
        ({"code": "javascript:alert(1)"}, "code: "),
        ({"date": "yesterday"}, "date: "),
        ({"about": "x\n\n## everyday, driving"}, "about: "),
        ({"authors": ["A", "B\n| 1. Forged | 1.000 |"]}, "authors[1]: "),
        ({"code": "https://a.b)[c](http://evil"}, "code: "),
        ({"about": "x" * 5000}, "has more than 4096 bytes"),
        (BOMB, "alias"),
        ("[" * 4000, ""),
        ("\x00", ""),
    ],
)
def test_a_wrong_entry_is_refused_in_one_line_and_others_stand(board, tmp_path, capsys, wrong, said):
    folder = by_hand(tmp_path / "board", "mine", **(wrong if isinstance(wrong, dict) else {}))
    if isinstance(wrong, str):
        (folder / "entry.yaml").write_text(wrong)
    by_hand(tmp_path / "board", "other", about="see *below* & above")
    assert board() == 1
    (line,) = refusals(capsys)
    assert "mine/entry.yaml" in line and said in line
    assert "[other](other)" in (tmp_path / "board" / "README.md").read_text()


def test_an_entry_cannot_lie_elsewhere(enter, tmp_path, capsys):
    for name in ("../mine", "Mine", "", "a/b", "."):
        assert enter(points(tmp_path / "all.jsonl", ASKED), name, "--split", SPLIT, "--system", "mine", *ABOUT) == 1
        assert "is no name of an entry" in capsys.readouterr().err


@pytest.mark.parametrize("what", ["entry.yaml", SPLIT, f"{SPLIT}/predictions.jsonl"])
def test_a_link_is_refused_and_nothing_of_it_is_shown(board, tmp_path, capsys, what):
    by_hand(tmp_path / "board", "theirs")
    secret = tmp_path / "secret"
    secret.write_text("root:x:0:0: a secret")
    place = by_hand(tmp_path / "board", "mine") / what
    if place.is_dir():
        shutil.rmtree(place)
    place.unlink(missing_ok=True)
    place.symlink_to(tmp_path / "board" / "theirs" / SPLIT if what == SPLIT else secret)
    assert board() == 1
    (line,) = refusals(capsys)
    text = (tmp_path / "board" / "README.md").read_text()
    assert f"{place}: is a link" in line and "secret" not in line + text and "[theirs](theirs)" in text


def test_text_of_an_entry_makes_no_row_no_tag_and_no_link(board, tmp_path):
    by_hand(
        tmp_path / "board", "mine", system="a | 1.000 |", about="<script>x</script> [b](http://evil) `c`", authors=["[d](e)|"]
    )
    assert board() == 0
    text = (tmp_path / "board" / "README.md").read_text()
    assert "<script" not in text.replace(r"\<script", "") and "[b](" not in text and "[d](" not in text
    rows = [line for line in text.splitlines() if line.startswith("| ")]
    assert len({len(re.findall(r"(?<!\\)\|", row)) for row in rows}) == 1


def test_an_entry_that_does_what_another_does_is_flagged(evaluations, enter, board, tmp_path):
    oracle = relabelled(evaluations[ORACLE], tmp_path / "source", handed=[])
    assert enter(evaluations[ORACLE], "oracle", "--system", "oracle check", "--role", "diagnostic", *ABOUT) == 0
    assert enter(oracle, "mine", "--system", "mine", *ABOUT) == 0
    assert enter(evaluations[DEPTH], "depth", "--system", "depth", *ABOUT) == 0
    assert board() == 0
    text = (tmp_path / "board" / "README.md").read_text()
    assert text.count("its actions are those of") == 1
    assert "≡ mine: its actions are those of oracle check in every run." in text


def forged(evaluations, cache, to):
    """An evaluation in which every run stops at once and claims the oracle's measurements, and a cache that agrees."""
    relabelled(evaluations[ORACLE], to, handed=[], where="server")
    manifest = read_manifest(to)
    runs = [run.model_copy(update={"trace": "S"}) for run in Score.read(to / "runs.jsonl")]
    (to / "runs.jsonl").write_text("".join(run.to_line() for run in runs))
    (to / "summary.json").unlink()
    job, code = replay_job(CONFIG, manifest), digest_code("ovman.runner", ENGINE)
    episodes = {one.id: one for one in of_scene(SCENE)}
    for run in runs:
        key = replay_key(*job, code, episodes[run.episode], run.seed, "S")
        Cache(cache / "replays").get_or_compute(key, run.to_json)
    return to


def test_no_cache_stands_for_a_replay(evaluations, enter, options, tmp_path, monkeypatch, capsys):
    """Anybody who can write files here, such as the process of an agent, can write a cache."""
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    made = forged(evaluations, tmp_path / "ovman", tmp_path / "source")
    assert enter(made, "mine", "--system", "mine", *ABOUT) == 0
    assert command("leaderboard", tmp_path / "board", *options) == 1
    assert refusals(capsys) and "[mine](mine)" not in (tmp_path / "board" / "README.md").read_text()
    assert command("verify", made, *options) == 1
    # A page that is made with a cache says so.
    assert command("leaderboard", tmp_path / "board", *options, "--cache", tmp_path / "ovman") == 0
    assert "not replayed" in (tmp_path / "board" / "README.md").read_text()


def test_a_folder_that_is_no_leaderboard_is_left_alone(board, tmp_path, capsys):
    name = "README.md"
    by_hand(tmp_path / "board", "mine")
    (tmp_path / "board" / name).write_text("# My notes\n")
    assert board() == 1
    assert f"{name}: is not a page of a leaderboard" in capsys.readouterr().err
    assert (tmp_path / "board" / name).read_text() == "# My notes\n"
    assert {path.name for path in (tmp_path / "board").iterdir()} == {"mine", name}
