"""`ovman score`: released predictions get what the release says, wrong files one line, and a part of a split is no score."""

from __future__ import annotations

import json

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from ovman.analysis.comparisons import Comparison
from ovman.analysis.rates import RATES
from ovman.analysis.rows import csv_text, read_rows
from ovman.cli import main
from ovman.entry.release import Release
from ovman.entry.score import as_json, as_text, score_file
from ovman.records.episode import Episode
from ovman.settings import MAIN
from tests.arms import CONFIG
from tests.episodes import DATA, EPISODES, released

RELEASE = Release(DATA, CONFIG)
PREDICTIONS = DATA / "predictions" / "main"
REFERENCE = PREDICTIONS / f"{CONFIG.comparisons.agent}.jsonl"
FILES = [(MAIN, path) for path in sorted(PREDICTIONS.glob("*.jsonl"))] + [
    (path.parent.name, path) for path in sorted(PREDICTIONS.parent.glob("[!m]*/*.jsonl"))
]


def score(path, release=RELEASE, split=MAIN, **options):
    return score_file(path, release, split, **options)


def written(tmp_path, lines):
    path = tmp_path / "mine.jsonl"
    path.write_text("".join(line if isinstance(line, str) else json.dumps(line) + "\n" for line in lines))
    return path


def everywhere(**answer):
    return [{"episode": episode.id, **answer} for episode in released()]


@pytest.mark.parametrize("split", sorted({split for split, _ in FILES}))
def test_released_predictions_get_the_released_rates(tmp_path, split):
    """To the last byte of every row of Table static and of the other splits. Without baselines, which take long."""
    (tmp_path / "episodes").symlink_to(DATA / "episodes")
    bare = Release(tmp_path, CONFIG, leaderboard=tmp_path)
    every = written(tmp_path, [path.read_text() for of, path in FILES if of == split])
    _, *wanted = (DATA / "metrics" / split / "static_rates.csv").read_text().splitlines()
    _, *found = csv_text(RATES, score(every, bare, split).rates).splitlines()
    assert sorted(found) == sorted(wanted) and len(wanted) > 70


def test_released_tests_are_found_again():
    """Where the release tests the reference arm against a control that was realised once, p and counts are those."""
    of = {
        (row.baseline, row.relation): row
        for row in read_rows(DATA / "metrics" / "main" / "significance.csv", Comparison, [REFERENCE.stem])
    }
    found = score(REFERENCE).baselines.tests
    both = [(test, of[test.baseline, test.relation]) for test in found if (test.baseline, test.relation) in of]
    assert len(both) >= 14
    for ours, theirs in both:
        for key in ("n", "successes", "baseline_successes", "wins", "losses", "test"):
            assert getattr(ours, key) == getattr(theirs, key)
        assert ours.p == pytest.approx(theirs.p, rel=1e-5)
        assert ours.p_holm == (None if theirs.p_holm is None else pytest.approx(theirs.p_holm, rel=1e-5))


@settings(max_examples=25, derandomize=True, deadline=None)
@given(st.floats(0.0, 2.0), st.sampled_from([(1.0, 0.0), (0.0, -1.0), (0.6, 0.8)]))
def test_the_radius_is_that_of_each_episode(tmp_path_factory, away_m, towards):
    """An episode whose protocol has another radius is judged by it, beside one that has the usual."""
    directory = tmp_path_factory.mktemp("radius")
    usual, other = released()[:2]
    record = other.to_json()
    record["protocol"]["success"]["radius_m"] = 0.25
    episodes = directory / "episodes.jsonl"
    episodes.write_text(usual.to_line() + json.dumps(record) + "\n")
    here = [
        {"episode": one.id, "x": one.answer[0] + away_m * towards[0], "z": one.answer[1] + away_m * towards[1]}
        for one in (usual, other)
    ]
    found = score(written(directory, here), episodes_file=episodes)
    assert found.radius_m == (0.25, 1.0) and found.split is None and found.baselines.released == []
    if min(abs(away_m - 0.25), abs(away_m - 1.0)) > 1e-9:
        assert found.rates[-1].successes == (away_m < 1.0) + (away_m < 0.25)


def test_a_control_that_reaches_the_score_is_named(tmp_path):
    text = as_text(score(written(tmp_path, everywhere(abstain="no_candidate"))))
    (line,) = (line for line in text.splitlines() if line.startswith("controls reach"))
    assert line.startswith("controls reach the score of mine, 0.000:") and "chance 1/n" in line


def test_runs_are_tested_one_by_one_and_picks_are_not(tmp_path):
    lines = [{**line, "seed": seed} for seed in (0, 1) for line in everywhere(x=0.0, z=float(seed))]
    runs = score(written(tmp_path, lines))
    assert {test.seed for test in runs.baselines.tests} == {0, 1} and {rate.seeds for rate in runs.rates} == {2}
    assert len([line for line in as_text(runs).splitlines() if "mine, seed 1" in line]) == len(
        {test.baseline for test in runs.baselines.tests}
    )
    pick = score(written(tmp_path, everywhere(candidates=[{"x": 0.0, "z": 0.0}])))
    assert pick.baselines.tests == [] and "mine, which is judged: a stochastic pick" in pick.baselines.untested


@pytest.mark.parametrize("partial", [False, True])
def test_a_part_is_no_score(tmp_path, capsys, partial):
    path = written(tmp_path, everywhere(x=0.0, z=0.0)[:50])
    assert main(["score", str(path), *["--partial"] * partial]) == 1
    said = capsys.readouterr()
    assert said.err == (
        f"ovman score: {path}: mine, seed 0: 169 of 219 episodes are missing; a part of the episodes of the split main is no"
        " score: answer them all, with an abstention where need be\n"
    )
    assert ("PARTIAL, 50 of 219 episodes, no score" in said.out) == partial
    assert partial or said.out == ""


def test_runs_that_lack_different_episodes_share_what_both_answer(tmp_path):
    whole = everywhere(candidates=[{"x": 0.0, "z": 0.0}])
    lines = [{**line, "seed": 0} for line in whole[:50]] + [{**line, "seed": 1} for line in whole[40:]]
    found = score(written(tmp_path, lines), partial=True)
    assert found.rates[-1].n == 10 and found.missing == {("mine", 0): 169, ("mine", 1): 40} and not found.baselines.tests


FIRST, SECOND = (episode.id for episode in Episode.load(EPISODES)[:2])


@pytest.mark.parametrize(
    ("lines", "said"),
    [
        (["{"], r":1: not JSON \(.*\); restore the line"),
        ([{"x": 1.0, "z": 1.0}], ":1: episode: the key is missing; add it"),
        ([{"episode": FIRST, "x": "1", "z": 1.0}], ':1: x: expected a number, found "1"; correct it'),
        ([{"episode": FIRST}], ':1: give exactly one of "x" and "z", "abstain"'),
        ([{"episode": FIRST, "x": 1, "z": 1}, {"episode": FIRST + "0", "x": 1, "z": 1}], ":2: episode: .* is none of .*--split"),
        (
            [{"episode": FIRST, "x": 1, "z": 1}, {"episode": SECOND, "x": 1, "z": 1}, {"episode": FIRST, "x": 2, "z": 1}],
            f":3: episode: {FIRST} is answered in line 1 already, .*; remove one of the two",
        ),
        ([{"schema": "ovman-run/1", "episode": FIRST, "x": 1, "z": 1}], ":1: schema: expected 'ovman-prediction/1'"),
        ([], ": holds no prediction; write one line per episode"),
    ],
)  # fmt: skip
def test_a_wrong_file_is_one_line(tmp_path, capsys, lines, said):
    path = written(tmp_path, lines)
    assert main(["score", str(path)]) == 1
    err = capsys.readouterr().err
    assert err.startswith(f"ovman score: {path}") and err.count("\n") == 1
    with pytest.raises(ValueError, match=said):
        score(path)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["absent.jsonl"], "absent.jsonl: No such file or directory; name a file of JSON lines"),
        ([str(REFERENCE), "--split", "mian"], "--split: mian is no split; write one of main, multi"),
        ([str(REFERENCE), "--episodes", "absent.jsonl"], "absent.jsonl: No such file or directory; name a file of episodes"),
        (
            [str(REFERENCE), "--release", str(DATA / "scores")],
            "scores/episodes/main.jsonl: the release has no episodes of the split main",
        ),
        ([str(REFERENCE), "--config", "absent.yaml"], "absent.yaml"),
    ],
)
def test_a_wrong_argument_is_one_line(capsys, arguments, said):
    assert main(["score", *arguments]) == 1
    err = capsys.readouterr().err
    assert said in err and err.count("\n") == 1


def test_on_a_split_without_released_rates_the_leaderboard_stands_beside(tmp_path, capsys):
    """Over the same episodes: what the entries reach on dev, and on a part of it."""
    episodes = Episode.load(RELEASE.episodes("dev"))
    points = [{"episode": one.id, "x": one.answer[0], "z": one.answer[1]} for one in episodes]
    entries = score(written(tmp_path, points), split="dev").baselines.entries
    assert {"reference agent", "depth difference (control)", "joint agent"} <= {*entries}
    assert round(entries["reference agent"][-1].rate, 3) == 0.456  # of leaderboard/README.md
    (tmp_path / "mine.jsonl").unlink()
    part = score(written(tmp_path, points[:16]), split="dev", partial=True)
    assert {rates[-1].n for rates in part.baselines.entries.values()} == {16}
    assert "reference agent" in as_text(part) and "leaderboard" in json.loads(as_json(part))
    assert not score(REFERENCE).baselines.entries
    assert main(["score", "--split", "dev", str(tmp_path / "mine.jsonl")]) == 1
    assert "44 of 60 episodes are missing" in capsys.readouterr().err
