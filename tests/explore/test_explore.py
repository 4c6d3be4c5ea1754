"""`ovman explore`: the page's numbers are those of the workflow's functions, in a browser too, and the released ones in force."""

from __future__ import annotations

import csv
import json
import random
import re
import shutil
import subprocess
from collections import Counter

import pytest

from ovman.cli import main
from ovman.explore.encoding import ALPHABET, GEOMETRY, OBSERVATION, REASONS, encoded
from ovman.explore.page import page
from ovman.explore.reading import NONE, reading
from ovman.explore.records import Records, read
from ovman.explore.setting import in_force, positions
from ovman.records.rejection import Rejection
from ovman.records.relation import Relation
from ovman.settings import MAIN
from tests.arms import CONFIG
from tests.episodes import DATA

CHROMIUM = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")
SCENES = ("FloorPlan1", "FloorPlan10", "FloorPlan201", "FloorPlan7")
DRAWS = random.Random(3)
SETTINGS = [
    {},
    {name: values[0] for name, values in positions(CONFIG).items()},
    {name: values[-1] for name, values in positions(CONFIG).items()},
    *({name: DRAWS.choice(values) for name, values in positions(CONFIG).items()} for _ in range(6)),
]


@pytest.fixture(scope="module")
def whole():
    return read(DATA, CONFIG, MAIN)


@pytest.fixture(scope="module")
def some(whole):
    """The records of some scenes."""
    there = [episode for episode in whole.episodes if episode.scene in SCENES]
    ids = {episode.id for episode in there}
    return Records(
        MAIN,
        [trial for trial in whole.trials if trial.candidate.scene in SCENES],
        whole.certified,
        there,
        {arm: [one for one in of if one.episode in ids] for arm, of in whole.predictions.items()},
        {arm: [one for one in of if one.episode in ids] for arm, of in whole.runs.items()},
    )


@pytest.fixture(scope="module")
def data(some):
    return encoded(some, CONFIG, lambda line: None)


def decoded(data, setting):
    """Rejections, episodes left and success over all, from the data of the page."""
    at = {name: values.index(({**in_force(CONFIG), **setting})[name]) for name, values in data["sliders"].items()}
    rejected, left = Counter(), set()
    for relation, *tables, episode in data["trials"]:
        for names, table in zip((GEOMETRY, OBSERVATION, ("drift_tolerance_m",), ("radius_m",)), tables, strict=True):
            text, place = data["tables"][table], 0
            for name in names if len(text) > 1 else ():
                place = place * len(data["sliders"][name]) + at[name]
            reason = REASONS[ALPHABET.index(text[place])]
            if reason != NONE:
                rejected[data["relations"][relation], reason] += 1
                break
        else:
            left |= {episode} - {-1}
    success = {}
    for arm in data["arms"]:
        values = []
        for run in arm["runs"]:
            for k in left:
                if isinstance(run, str):
                    values += [] if run[k] == " " else [run[k] != "-" and ALPHABET.index(run[k]) <= at["radius_m"]]
                elif run[k][at["radius_m"]] is not None:
                    values.append(run[k][at["radius_m"]])
        if values:
            success[arm["name"]] = sum(values) / len(values)
    return rejected, Counter(data["relations"][data["episodes"][k]] for k in left), success


@pytest.mark.parametrize("setting", SETTINGS, ids=range(len(SETTINGS)))
def test_the_data_of_the_page_are_what_the_functions_say(some, data, setting):
    found, (rejected, left, success) = reading(some, CONFIG, setting), decoded(data, setting)
    assert rejected == found.rejected and left == found.left
    assert success == pytest.approx({arm: rates["all"] for arm, rates in found.success.items()}, abs=1e-6)


def test_settings_say_different_things(some):
    """Else nothing is compared above."""
    found = [reading(some, CONFIG, setting) for setting in SETTINGS]
    assert len({one.left.total() for one in found}) > 4 and len({str(one.rejected) for one in found}) > 4


def test_in_force_it_is_the_release(whole):
    found = reading(whole, CONFIG, {})
    with (DATA / "metrics" / "rejections.csv").open() as file:
        audited = list(csv.DictReader(file))
    shared = Rejection.SHARED_TOURS
    wanted = {(row["relation"], row["reason"]): int(row["count"]) for row in audited if row["reason"] not in ("", shared)}
    assert found.rejected == wanted
    released = {row["relation"]: int(row["count"]) for row in audited if row["stage"] == "released"}
    assert found.left == released
    for kind in ("static", "embodied"):
        with (DATA / "metrics" / f"{kind}_rates.csv").open() as file:
            rows = [row for row in csv.DictReader(file) if row["arm"] in found.success]
        assert len({row["arm"] for row in rows}) > 8
        for row in rows:
            assert found.success[row["arm"]][row["relation"]] == pytest.approx(float(row["rate"]), abs=1e-6)
    with (DATA / "metrics" / "sensitivity.csv").open() as file:
        margin = next(float(row["released_margin"]) for row in csv.DictReader(file) if row["setting"] == "0")
    assert found.margin == pytest.approx(margin, abs=1e-6)


def test_what_was_not_measured_is_no_position():
    bounds = CONFIG.measurement.model_copy(update={"min_mask_px": 250, "answer_to_navigable_m": 0.95})
    found = positions(CONFIG.model_copy(update={"measurement": bounds}))
    assert found["min_mask_px"][0] == 300 and found["validity_radius_m"][-1] == 0.9
    assert all(in_force(CONFIG)[name] in values and values == sorted(values) for name, values in found.items())


def shown(path, setting):
    """What a browser shows of the page: texts by the reason or arm of their row, and by id."""
    asked = "&".join(f"{name}={value}" for name, value in setting.items())
    command = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--virtual-time-budget=10000", "--dump-dom"]
    html = subprocess.run([*command, f"file://{path}#{asked}"], capture_output=True, text=True, check=True, timeout=120).stdout
    assert 'data-ready="yes"' in html
    rows = {}
    for kind, name, row in re.findall(r'<tr[^>]*data-(reason|arm)="(\w+)"[^>]*>(.*?)</tr>', html, re.DOTALL):
        rows[kind, name] = [
            re.sub(r"<small>.*?</small>|<[^>]*>", "", cell) for cell in re.findall(r"<td.*?</td>", row, re.DOTALL)
        ]
    return rows, dict(re.findall(r'id="(left|certified|margin)">([^<]*)<', html))


@pytest.mark.skipif(CHROMIUM is None, reason="no Chromium on this machine")
@pytest.mark.parametrize("setting", SETTINGS[:1] + SETTINGS[3:5], ids=("in force", "one", "another"))
def test_a_browser_shows_what_the_functions_say(some, data, tmp_path, setting):
    (tmp_path / "explore.html").write_text(page(data, CONFIG), encoding="utf-8")
    rows, figures = shown(tmp_path / "explore.html", setting)
    found = reading(some, CONFIG, setting)
    relations = [str(relation) for relation in Relation]

    def counts(of):
        values = [of.get(relation, 0) for relation in relations]
        return [str(value) if value else "·" for value in (*values, sum(values))]

    reasons = {reason for _, reason in found.rejected}
    assert {name for kind, name in rows if kind == "reason"} >= {*reasons, "left"}
    for reason in reasons:
        of = {relation: found.rejected[relation, reason] for relation in relations}
        assert rows["reason", reason] == counts(of)
    assert rows["reason", "left"] == counts(found.left)
    assert figures["left"] == str(found.left.total()) and figures["certified"] == str(sum(found.certified.values()))
    assert float(figures["margin"]) == pytest.approx(found.margin, abs=6e-4)
    for arm, rates in found.success.items():
        _, over_all, *by_relation = rows["arm", arm]
        wanted = [rates["all"], *(rates.get(relation) for relation in relations)]
        for text, value in zip([over_all, *by_relation], wanted, strict=True):
            assert text == "–" if value is None else float(text) == pytest.approx(value, abs=6e-4)


def test_the_page_stands_alone(data):
    text = page(data, CONFIG)
    assert not re.search(r"(?:src|href)=|https?://|@import|fetch\(", text.replace("http://www.w3.org", ""))
    assert text == page(data, CONFIG)
    assert all(f'<label for="{name}"' in text and f'id="{name}" type="range"' in text for name in data["sliders"])
    hostile = json.loads(json.dumps(data))
    hostile["arms"][0]["title"] = "</script><b>"
    assert "</script><b>" not in page(hostile, CONFIG)


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--split", "nowhere"], "--split: nowhere is no split"),
        (["--release", "nowhere"], "nowhere/episodes/main.jsonl"),
        (["--config", "nowhere.yaml"], "nowhere.yaml"),
    ],
)
def test_a_wrong_command_is_one_line(tmp_path, monkeypatch, capsys, options, said):
    monkeypatch.chdir(tmp_path)
    assert main(["explore", *options]) == 1
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("ovman explore: ") and said in line and not list(tmp_path.iterdir())
