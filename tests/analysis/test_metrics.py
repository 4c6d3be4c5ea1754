"""The metrics of a split follow from its records, whatever the order of the files."""

from __future__ import annotations

import json

import pandas as pd
import pytest

from ovman.analysis.metrics import write_metrics
from ovman.analysis.registry import SPLIT_METRICS
from tests.arms import BY_NAME, CONFIG
from tests.episodes import episode_record


def constants(*arms):
    return CONFIG.model_copy(update={"arms": {arm.name: arm for arm in arms or EVERY}})


TERMS = ("stop", "box_distance_m", "answer_distance_m", "navigable_distance_m", "visible_px")
EVERY = [BY_NAME[name] for name in ("positions_single_visit", "positions_two_visits", "oracle_check")]
WORLD = [{"id": "a", "category": "Chair", "x": 1.0, "z": 0.0}, {"id": "b", "category": "Chair", "x": -4.0, "z": 0.0}]


def records(tmp_path, reverse=False):
    """Two episodes, two static arms, one embodied arm of two seeds, as files; ``EVERY`` is all arms that there are."""
    episodes = [episode_record(relation, world=WORLD) for relation in ("moved", "former")]

    def prediction(episode, arm, **form):
        return {"schema": "ovman-prediction/1", "episode": episode["id"], "arm": arm, "seed": 0, **form}

    def run(episode, seed, success):
        return {"schema": "ovman-run/1", "episode": episode["id"], "arm": "oracle_check", "seed": seed, "outcome": "stopped",
                "success": success, "spl": 0.5 * success, "path_length_m": 2.0, "actions": 7, **dict.fromkeys(TERMS)}  # fmt: skip

    box = {"x_min": -2.0, "z_min": -2.0, "x_max": 2.0, "z_max": 2.0}
    files = {
        "episodes": episodes,
        "positions_two_visits": [prediction(episodes[0], "positions_two_visits", x=1.5, z=0.0),
                                 prediction(episodes[1], "positions_two_visits", abstain="no_candidate")],
        "positions_single_visit": [prediction(episodes[0], "positions_single_visit",
                                              candidates=[{"x": 1.0, "z": 0.0}, {"x": 9.0, "z": 0.0}]),
                                   prediction(episodes[1], "positions_single_visit", box=box)],
        "seed0": [run(episode, 0, True) for episode in episodes],
        "seed1": [run(episode, 1, index == 0) for index, episode in enumerate(episodes)],
    }  # fmt: skip
    paths = {}
    for name, lines in files.items():
        paths[name] = tmp_path / f"{name}.jsonl"
        kept = list(reversed(lines)) if reverse and name != "episodes" else lines
        paths[name].write_text("".join(json.dumps(line) + "\n" for line in kept))
    predictions = [paths["positions_two_visits"], paths["positions_single_visit"]]
    runs = [paths["seed0"], paths["seed1"]]
    return paths["episodes"], (predictions[::-1] if reverse else predictions), (runs[::-1] if reverse else runs)


def test_metrics_do_not_hang_on_the_order_of_files(tmp_path):
    for name, reverse in (("one", False), ("other", True)):
        (tmp_path / name).mkdir()
        write_metrics(*records(tmp_path / name, reverse), constants(), tmp_path / name / "metrics")
    names = sorted(path.name for path in (tmp_path / "one" / "metrics").iterdir())
    assert names == sorted(f"{name}.csv" for name in SPLIT_METRICS)
    for name in names:
        one, other = ((tmp_path / where / "metrics" / name).read_bytes() for where in ("one", "other"))
        assert one == other and b"\r" not in one


@pytest.mark.parametrize(("answers", "arms"), [(True, ["positions_single_visit", "positions_two_visits"]),
                                               (False, ["positions_single_visit"])])  # fmt: skip
def test_an_arm_that_a_plug_in_makes_may_have_answered_nothing_and_is_read_where_it_has(tmp_path, answers, arms):
    every = [arm.model_copy(update={"made_by": "plugin"}) if arm.name == "positions_two_visits" else arm for arm in EVERY]
    episodes, predictions, runs = records(tmp_path)
    if not answers:
        predictions[0].write_text("")
    write_metrics(episodes, predictions, runs, constants(*every), tmp_path / "metrics")
    assert [*pd.read_csv(tmp_path / "metrics" / "static_rates.csv")["arm"].unique()] == arms


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ("runs", "positions_two_visits: predictions of 1 runs, but its entry in section arms says 2"),
        ("nothing", "has no predictions; make the file again"),
        ("stranger", "'mine' is not an arm that is static"),
    ],
)
def test_predictions_that_do_not_fit_the_arms_are_refused(tmp_path, change, says):
    episodes, predictions, runs = records(tmp_path)
    arms = [arm.model_copy(update={"runs": 2}) if change == "runs" and "two" in arm.name else arm for arm in EVERY]
    text = predictions[0].read_text()
    predictions[0].write_text({"runs": text, "nothing": "", "stranger": text.replace("positions_two_visits", "mine")}[change])
    with pytest.raises(ValueError, match=says):
        write_metrics(episodes, predictions, runs, constants(*arms), tmp_path / "metrics")
