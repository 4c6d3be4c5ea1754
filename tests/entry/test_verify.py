"""`ovman verify`: what was recorded is driven again and agrees; whatever is changed afterwards is found, and named."""

from __future__ import annotations

import json
import shutil
from functools import partial

import pytest

from ovman.cache import Cache
from ovman.entry import command as entry
from ovman.entry.verification import verify
from ovman.records.run import Score
from tests.entry.evaluations import ASKED, WANDERER, command, contents, lines, moving


@pytest.fixture
def copy(depth_driving, tmp_path):
    """The evaluation, to be changed."""
    return shutil.copytree(depth_driving, tmp_path / "copy")


@pytest.fixture(scope="module")
def replays(tmp_path_factory):
    """Replays, as `ovman leaderboard --cache` keeps them."""
    return Cache(tmp_path_factory.mktemp("replays"))


@pytest.fixture
def remembering(replays, monkeypatch):
    """Verification drives what it has not driven before: of changed files, the actions that were changed."""
    monkeypatch.setattr(entry, "verify", partial(verify, cache=replays))


def changed(directory, number, **values):
    """Change a run of the evaluation."""
    path = directory / "runs.jsonl"
    runs = [json.loads(line) for line in lines(path)]
    runs[number] |= values
    path.write_text("".join(json.dumps(run, separators=(",", ":")) + "\n" for run in runs))


def test_an_evaluation_agrees_with_itself(depth_driving, capsys):
    before = contents(depth_driving)
    assert command("verify", depth_driving) == 0
    assert f"all {2 * ASKED} runs agree" in lines_of(capsys)[-1]
    assert contents(depth_driving) == before


def lines_of(capsys):
    found = capsys.readouterr()
    return found.out.splitlines() + found.err.splitlines()


def test_an_agent_that_draws_and_looks_agrees_where_things_move(tmp_path, tours, monkeypatch, capsys):
    """The agent's own draws and looks leave those of the mover alone: the trace is enough."""
    (tmp_path / "wanderer.py").write_text(WANDERER)
    (tmp_path / "moving.jsonl").write_text(moving().to_line())
    monkeypatch.chdir(tmp_path)
    options = ["--agent", "wanderer:Wanderer", "--needs", "--episodes", "moving.jsonl", "--seeds", "0", "1"]
    assert command("eval", "--out", "out", "--cache", tours, *options) == 0
    assert len({run.trace for run in Score.read(tmp_path / "out" / "runs.jsonl")}) == 2
    (tmp_path / "wanderer.py").unlink()
    assert command("verify", "out", "--episodes", "moving.jsonl") == 0


@pytest.mark.parametrize(
    ("key", "value"),
    [("success", None), ("trace", "S"), ("actions", 3), ("path_length_m", 0.25), ("answer_distance_m", 0.1), ("spl", 0.123)],
)
def test_a_changed_run_is_found_with_its_line_and_key(copy, remembering, capsys, key, value):
    run = json.loads(lines(copy / "runs.jsonl")[2])
    changed(copy, 2, **{key: not run["success"] if key == "success" else value})
    assert command("verify", copy) == 1
    said = lines_of(capsys)
    where = f"{copy}/runs.jsonl:3: {run['episode']}, seed {run['seed']}: "
    assert any(line.startswith(where) for line in said)
    if key != "trace":
        assert any(line.startswith(f"{where}{key}: ") for line in said)
    assert "1 differ" in said[-1]


@pytest.mark.parametrize(
    ("name", "change", "said"),
    [
        ("runs.jsonl", lambda text: text.split("\n", 1)[1], "nothing recorded, a run is asked for"),
        ("runs.jsonl", lambda text: text + text.split("\n", 1)[0] + "\n", "too: one run is asked for"),
        ("runs.jsonl", lambda text: text.replace('"seed":1', '"seed":7'), "recorded, not asked for"),
        ("runs.jsonl", lambda text: text.replace('"arm":"', '"arm":"x', 1), "arm: x"),
        ("runs.jsonl", lambda text: text.replace('"trace":"', '"tracé":"', 1), "runs.jsonl:1"),
        ("manifest.json", lambda text: text.replace('"sha256":"', '"sha256":"0'), "sha256: 0"),
        ("manifest.json", lambda text: text.replace('"n":219', '"n":2'), "n: 2 recorded, 219 in"),
        ("manifest.json", lambda text: text.replace('"seeds":[0,1]', '"seeds":[0,0,1]'), "each stands once"),
        ("summary.json", lambda text: text.replace('"successes": ', '"successes": 1', 1), "recorded, the runs come to"),
        ("summary.json", lambda text: "[" * 200_000, "is no JSON"),
        ("summary.json", lambda text: text.replace('"whole"', '"\\u001b[2J\\nall 4 runs agree"'), r"\x1b[2J\nall 4 runs agree"),
        ("manifest.json", lambda text: text.replace('"arm":"', '"arm":"x\\nall 4 runs agree', 1), "manifest.json:1: arm: "),
        ("runs.jsonl", lambda text: text.replace('"episode":"', '"episode":"\\u001b[2J\\n', 1), "runs.jsonl:1: episode: "),
    ],
)
def test_a_changed_file_is_found(copy, remembering, capsys, name, change, said):
    text = (copy / name).read_text()
    assert change(text) != text
    (copy / name).write_text(change(text))
    assert command("verify", copy) == 1
    found = lines_of(capsys)
    assert any(said in line for line in found), found
    assert not any("Traceback" in line or not line.isprintable() or line.startswith("all") for line in found)


@pytest.mark.parametrize(
    ("made", "said"),
    [
        (lambda folder: None, "manifest.json"),
        (lambda folder: (folder / "manifest.json").write_text("{}\n"), "manifest.json"),
    ],
)
def test_what_is_no_evaluation_is_one_line(tmp_path, capsys, made, said):
    made(tmp_path)
    assert command("verify", tmp_path) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ovman verify: ") and said in line
