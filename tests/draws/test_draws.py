"""Draws: equal seeds give equal bytes, agents run on them, and only agents that are older than the seed have a rank."""

from __future__ import annotations

import json
import shutil

import pytest
import yaml

from ovman.draws.making import settings_of_draw
from ovman.records.draw import Beacon, Draw
from ovman.records.episode import Episode
from ovman.report.show.results import Results
from ovman.settings.config import load
from tests.entry.evaluations import DEPTH, ORACLE, SCENE, command, contents
from tests.episodes import of_scene
from tests.shared import made_once
from tests.test_config import SPLIT, changed

NONE = dict.fromkeys(SPLIT["draws"], 0)
TREE = changed(
    {
        "splits.own": SPLIT
        | {
            "homes": {"seed": 4, "count": 3, "rooms": [1], "assets": "test"},
            "episodes": NONE | {"removed": 1},
            "draws": NONE | {"removed": 3},
            "in_main_job": False,
        },
        "admissibility.runs": 1,
        "evaluation.seeds": [0],
    }
)
DESIGN = ("--split", "own", "--homes", 1)
ROUND = {
    "round": 1000,
    "signature": "b44679b9a59af2ec876b1a6b1ad52ea9b1615fc3982b19576350f93447cb1125e342b73a8dd2bacbe47e4b6b63ed5e39",
}
"""drand's answer for a round of its chain quicknet."""
OTHER_SIGNATURE = "94385d48ab9d338824a523ff7d310fbeeac0184598d56b49f27857bcd3ef91f6ead1c7ef99c9beee47784ebba5c635de"
"""The signature of that round plus a point outside the signatures' group: the equation of the signature holds, too."""
ROUND_TIME = "2023-08-23T15:59:24Z"
FAR = "2999-01-01T00:00:00Z"
ABOUT = ["--author", "A. Author", "--about", "What it is."]


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """A folder with the settings, a release whose split dev has two episodes, a commitment, and a draw of each way."""

    def make(root):
        (root / "release" / "episodes").mkdir(parents=True)
        (root / "release" / "episodes" / "dev.jsonl").write_text("".join(one.to_line() for one in of_scene(SCENE)))
        (root / "settings.yaml").write_text(yaml.safe_dump(TREE, sort_keys=False))
        (root / "round.json").write_text(json.dumps(ROUND))
        config = "--config", root / "settings.yaml"
        assert command("commit", *DESIGN, "--closes", FAR, "--seed", "of the test", "--out", root / "seed", *config) == 0
        secret = root / "seed" / "secret.json"
        assert command("draw", "--reveal", secret, "--out", root / "revealed", *config) == 0
        assert command("draw", "--beacon", root / "round.json", *DESIGN, "--out", root / "lit", *config) == 0

    return made_once(tmp_path_factory, "draws", make)


@pytest.fixture(scope="module")
def config(root):
    """The option with the settings."""
    return "--config", root / "settings.yaml"


@pytest.fixture(scope="module")
def evaluations(root, config, tours, tmp_path_factory):
    """Evaluations on the public split and on both draws, by arm and place."""
    made = {}
    for arm in (DEPTH, ORACLE):
        for place, episodes in (
            ("dev", ["--split", "dev"]),
            *((name, ["--episodes", root / name]) for name in ("revealed", "lit")),
        ):
            made[arm, place] = tmp_path_factory.mktemp("evaluation") / "out"
            options = ["--cache", tours, "--release", root / "release", *config]
            assert command("eval", "--arm", arm, *episodes, "--out", made[arm, place], *options) == 0
    return made


@pytest.fixture
def refuse(capsys):
    """Runs a command that fails, and returns the one line that it says."""

    def run(*options):
        capsys.readouterr()
        assert command(*options) in (1, 2)
        (line,) = capsys.readouterr().err.splitlines()
        return line

    return run


def copied(source, to, **values):
    """A copy of a draw with other values in its manifest."""
    shutil.copytree(source, to)
    path = to / "manifest.json"
    path.write_text(json.dumps(json.loads(path.read_text()) | values))
    return to


def manifest(directory):
    return Draw.parse((directory / "manifest.json").read_bytes())


def test_equal_seeds_give_equal_bytes_and_other_seeds_other_homes(root, config, tmp_path, capsys):
    """The seed is any text: that of a commitment gives the same files when somebody writes it."""
    assert command("draw", "--seed", "of the test", *DESIGN, "--out", tmp_path / "again", *config) == 0
    first, again = contents(root / "revealed"), contents(tmp_path / "again")
    assert {name: text for name, text in first.items() if name != "manifest.json"} == {
        name: text for name, text in again.items() if name != "manifest.json"
    }
    assert not list(tmp_path.glob(".*"))
    assert {episode.scene for episode in Episode.load(root / "revealed" / "episodes.jsonl")} == {
        *manifest(root / "revealed").scenes
    }
    stems = {settings_of_draw(load(TREE), "own", seed, 2).splits["own"].homes.stems for seed in ("1", "01", "1" * 1000, "é")}
    assert len(stems) == 4
    assert command("verify", tmp_path / "again", *config) == 0
    assert "the same files" in capsys.readouterr().out


def test_progress_of_a_draw_is_apart_from_its_json_or_quiet(config, tmp_path, capsys):
    """Stages of the workflow print progress of their own."""
    words = "draw", "--seed", "of the test", *DESIGN, *config, "--out"
    assert command(*words, tmp_path / "told", "--json") == 0
    shown = capsys.readouterr()
    assert json.loads(shown.out)["manifest"]["n"] == manifest(tmp_path / "told").n and "certification" in shown.err
    assert command(*words, tmp_path / "quiet", "--quiet") == 0
    assert capsys.readouterr() == ("", "")
    assert contents(tmp_path / "told") == contents(tmp_path / "quiet")


def test_every_certified_episode_is_released(root):
    """The settings ask for one."""
    most = 0
    for name in ("revealed", "lit"):
        rows = [line.split(",") for line in (root / name / "rejections.csv").read_text().splitlines()]
        counts = {(row[0], row[1]): int(row[3]) for row in rows[1:] if not row[2]}
        assert counts["removed", "released"] == counts["removed", "certified"] == manifest(root / name).n
        most = max(most, manifest(root / name).n)
    assert most > 1


def test_an_evaluation_names_its_draw_and_is_verified_on_it(root, config, evaluations, refuse, capsys):
    out, draw = evaluations[DEPTH, "lit"], manifest(root / "lit")
    made = json.loads((out / "manifest.json").read_text())
    assert made["draw"] == draw.name and made["sha256"] == draw.files["episodes.jsonl"] and made["split"] is None
    assert command("verify", out, "--episodes", root / "lit", *config) == 0
    assert "agree" in capsys.readouterr().out
    assert "sha256" in refuse("verify", out, "--episodes", root / "revealed", *config)
    points = out.parent / "points.jsonl"
    episodes = Episode.load(root / "lit" / "episodes.jsonl")
    points.write_text("".join(json.dumps({"episode": one.id, "x": one.answer[0], "z": one.answer[1]}) + "\n" for one in episodes))
    assert command("score", points, "--episodes", root / "lit", *config) == 0
    assert "1.000" in capsys.readouterr().out
    results = Results(root / "lit", load(TREE))
    assert [results.scene(episode).scene for episode in results.episodes.values()] == [one.scene for one in episodes]


@pytest.mark.parametrize("name", ["episodes.jsonl", "sightings.jsonl", "rejections.csv"])
def test_a_changed_file_of_a_draw_is_refused(root, config, tmp_path, refuse, name):
    draw = copied(root / "lit", tmp_path / "draw")
    (draw / name).write_text((draw / name).read_text().replace("0", "1", 1))
    for words in (["eval", "--arm", DEPTH, "--out", tmp_path / "out", "--episodes", draw], ["verify", draw]):
        assert f"{draw / name}: was changed" in refuse(*words, *config)


@pytest.mark.parametrize(
    ("values", "said"),
    [
        ({"seed": "another"}, "seed: is not that of the beacon"),
        ({"beacon": ROUND | {"round": 1001}}, "signature: is not drand's for round 1001"),
        ({"beacon": ROUND | {"signature": "c0" + 47 * "00"}}, "signature: is not drand's"),
        ({"beacon": ROUND | {"signature": OTHER_SIGNATURE}}, "signature: is not drand's"),
        ({"beacon": ROUND | {"randomness": 64 * "0"}}, "randomness: is not the SHA-256"),
        ({"scenes": ["Home-test-1-4.0-00000000"]}, "scenes: are not homes of the seed"),
        ({"settings": "0"}, "settings: others than those here"),
        ({"homes": 2}, "settings: others than those here"),
        ({"files": {"../episodes.jsonl": 64 * "0", "episodes.jsonl": 64 * "0"}}, "is not there"),
        ({"beacon": None, "seed": "my own"}, "its seed was chosen freely"),
    ],
)
def test_a_manifest_that_contradicts_itself_is_refused(root, config, tmp_path, refuse, values, said):
    draw = copied(root / "lit", tmp_path / "draw", **values)
    assert said in refuse("leaderboard", tmp_path, "--draw", draw, *config)


def test_episodes_of_other_homes_are_refused(root, config, tmp_path, refuse):
    """The names of the homes in the manifest begin as those of the seed do."""
    scenes = [f"{scene[:-8]}00000000" for scene in manifest(root / "lit").scenes]
    assert "does not follow from the seed" in refuse(
        "leaderboard", tmp_path, "--draw", copied(root / "lit", tmp_path / "draw", scenes=scenes), *config
    )


def test_a_wrong_draw_is_refused_in_one_line(root, config, tmp_path, refuse):
    out = "--out", tmp_path / "draw"
    assert "holds something already" in refuse("draw", "--seed", 1, *DESIGN, "--out", root / "lit", *config)
    assert "dev has floor plans" in refuse("draw", "--seed", 1, "--split", "dev", "--homes", 1, *out, *config)
    assert "owl is not a split; write one with homes: " in refuse(
        "draw", "--seed", 1, "--split", "owl", "--homes", 1, *out, *config
    )
    assert "write at least 1" in refuse("draw", "--seed", 1, "--split", "own", "--homes", 0, *out, *config)
    assert "--split NAME and --homes N" in refuse("draw", "--seed", 1, *out, *config)
    assert "names split and homes" in refuse("draw", "--reveal", root / "seed" / "secret.json", *DESIGN, *out, *config)
    public = root / "seed" / "commitment.json"
    assert "of the test" not in public.read_text() and "no seed and salt" in refuse("draw", "--reveal", public, *out, *config)
    secret = tmp_path / "secret.json"
    secret.write_text((root / "seed" / "secret.json").read_text().replace("of the test", "of another"))
    assert "sha256: seed and salt have another digest" in refuse("draw", "--reveal", secret, *out, *config)
    assert "No such file" in refuse("draw", "--beacon", tmp_path / "none.json", *DESIGN, *out, *config)
    assert "is there already" in refuse("commit", *DESIGN, "--closes", FAR, "--out", root / "seed", *config)
    assert "has passed" in refuse("commit", *DESIGN, "--closes", "2001-01-01T00:00:00Z", "--out", tmp_path / "seed", *config)
    assert "is not a time" in refuse("commit", *DESIGN, "--closes", "soon", "--out", tmp_path / "seed", *config)
    assert not (tmp_path / "draw").exists() and not (tmp_path / "seed").exists()


def test_a_round_has_the_time_that_drand_gives_it():
    """The value and the time are those that drand's documentation has for the round."""
    beacon = Beacon(**ROUND)
    assert beacon.value == "fe290beca10872ef2fb164d2aa4442de4566183ec51c56ff3cd603d930e54fdd"
    assert beacon.time == ROUND_TIME and Beacon(**ROUND | {"round": 1001}).time == "2023-08-23T15:59:27Z"


def test_agents_that_are_older_than_the_seed_rank(root, config, evaluations, refuse, tmp_path, capsys):
    board = tmp_path / "board"
    options = "--release", root / "release", *config
    for arm, role in ((DEPTH, "system"), (ORACLE, "diagnostic")):
        name, own = arm.replace("_", "-"), ("--leaderboard", board, *options)
        assert command("enter", evaluations[arm, "dev"], name, "--system", arm, "--role", role, *ABOUT, *own) == 0
        assert command("commit", board / name) == 0
        assert "is there already" in refuse("commit", board / name)
        for place in ("revealed", "lit"):
            assert command("enter", evaluations[arm, place], name, *own) == 0
    commitment = board / DEPTH.replace("_", "-") / "commitment.json"

    def table(*draws):
        """Whether all stand, and the row of the control among them; its commitment counts."""
        names = [option for draw in draws for option in ("--draw", root / draw)]
        well = command("leaderboard", board, *names, "--cache", tmp_path / "cache", *options) == 0
        text = (board / "README.md").read_text()
        fresh = text[text.index("## Fresh draws") : text.index("## Public splits")]
        return well, next((line for line in fresh.splitlines() if f"[{DEPTH}]" in line), None), text

    well, row, text = table("revealed")
    assert well and row.startswith("| 1. ") and "told after" in text
    assert "left out; name the folder of its draw" in capsys.readouterr().out
    assert "1. " not in text[text.index("## Public splits") :]
    well, row, text = table("revealed", "lit")
    assert not well and row.startswith(f"| [{DEPTH}]") and "—" in row and f"public from {ROUND_TIME}" in text
    older = json.loads(commitment.read_text()) | {"time": "2023-08-23T15:59:23Z"}
    commitment.write_text(json.dumps(older))
    assert table("lit")[1].startswith("| 1. ")
    commitment.write_text(json.dumps(older | {"time": ROUND_TIME}))
    assert table("lit")[1] is None
    commitment.write_text(json.dumps(older | {"agents": [older["agents"][0] | {"code": "another"}]}))
    well, row, text = table("lit")
    assert row is None and "run the committed agent" in text
    commitment.unlink()
    assert "commit before the next draw" in table("lit")[2]
    assert "two draws have one seed" in refuse("leaderboard", board, *["--draw", root / "lit"] * 2, *options)


def test_an_agent_on_a_server_is_committed_by_its_files(root, config, evaluations, refuse, tmp_path):
    board, source = tmp_path / "board", copied(evaluations[DEPTH, "dev"], tmp_path / "source", where="server")
    options = "--release", root / "release", *config, "--leaderboard", board
    assert command("enter", source, "mine", "--system", "mine", *ABOUT, *options) == 0
    assert "name its files with --files" in refuse("commit", board / "mine")
    assert "--files: " in refuse("commit", board / "mine", "--files", tmp_path / "none")
    weights = tmp_path / "weights" / "a.bin"
    weights.parent.mkdir()
    weights.write_bytes(b"abc")
    assert command("commit", board / "mine", "--files", weights.parent) == 0
    (digest,) = json.loads((board / "mine" / "commitment.json").read_text())["files"].values()
    assert digest.startswith("ba7816bf")
