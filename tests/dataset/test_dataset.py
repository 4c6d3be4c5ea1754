"""`ovman dataset`: what others load is what the records and the recorded tours say, and an agent's inputs hold no truth."""

from __future__ import annotations

import io
import json
import re
import shutil
import socket
import subprocess
import sys
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import mlcroissant
import numpy as np
import pytest
import yaml
from PIL import Image

from ovman.agents.interface import VISITS
from ovman.cli import main
from ovman.dataset.making import SUMS
from ovman.dataset.tables import PREDICTIONS, RUNS, TABLES, TOURS, intrinsics, tour_id
from ovman.evaluation.recorded_tours import load_visit
from ovman.evaluation.tours import TourCache
from ovman.perception.backprojection import Camera, pixel_points
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.record import lines
from ovman.records.run import Score
from ovman.records.visit import VisitFiles, VisitManifest, tour_path
from ovman.settings.benchmark import Camera as Lens
from ovman.sim.session import Session
from tests.episodes import DATA, ROOT
from tests.tour_zips import contents, rewrite

SCENE = "FloorPlan10"
"""A small floor plan."""
SPLITS = {"main": 1, "everyday": 1}
"""Exact sensors, and such that err."""
ASKED = ("hasSyntheticData", "dataLimitations", "dataBiases", "personalSensitiveInformation", "dataUseCases", "dataSocialImpact")
"""What the NeurIPS track asks for of the vocabulary for responsible AI."""


@dataclass(frozen=True)
class Small:
    """A data set of a small release. release, cache: what it was made of; made: its folder; episodes: by split."""

    release: Path
    cache: Path
    made: Path
    episodes: dict[str, list[Episode]]

    @property
    def every(self) -> list[Episode]:
        return [episode for episodes in self.episodes.values() for episode in episodes]

    def make(self, out: Path, *options: str) -> int:
        return main(["dataset", "--release", str(self.release), "--cache", str(self.cache), "--out", str(out), *options])

    def records(self, folder: str, of: type) -> list:
        """The records below a folder of the release, sorted by all that they say."""
        return sorted((record for file in (self.release / folder).rglob("*.jsonl") for record in of.read(file)), key=str)


@pytest.fixture(scope="module", autouse=True)
def offline():
    """No connection to another machine is made while a data set is written or read."""
    with pytest.MonkeyPatch.context() as patched:
        patched.setenv("HF_HUB_OFFLINE", "1")
        patched.setattr(socket.socket, "connect", lambda *_: pytest.fail("a connection was asked for"))
        yield


@pytest.fixture(scope="module")
def small(tmp_path_factory) -> Small:
    release, cache, made = (tmp_path_factory.mktemp(name) for name in ("release", "cache", "made"))
    released = {split: Episode.load(DATA / "episodes" / f"{split}.jsonl") for split in SPLITS}
    episodes = {
        split: [one for one in released[split] if split == "everyday" or one.scene == SCENE][:number]
        for split, number in SPLITS.items()
    }
    (release / "episodes").mkdir()
    for split, some in episodes.items():
        (release / "episodes" / f"{split}.jsonl").write_text(lines(some), encoding="utf-8")
    ids = {episode.id for some in episodes.values() for episode in some}
    for file in [file for folder in ("predictions", "scores") for file in (DATA / folder).rglob("*.jsonl")]:
        mentioned = [line for line in file.read_text(encoding="utf-8").splitlines(True) if any(one in line for one in ids)]
        place = release / file.relative_to(DATA)
        place.parent.mkdir(parents=True, exist_ok=True)
        place.write_text("".join(mentioned), encoding="utf-8")
    found = Small(release, cache, made, episodes)
    assert found.make(made) == 0
    return found


@pytest.fixture(scope="module")
def loaded(small, tmp_path_factory):
    """Rows of a configuration by split, as `datasets` reads them from the folder; pictures as their bytes."""
    from datasets import Image as Picture
    from datasets import load_dataset

    cache = tmp_path_factory.mktemp("hf")

    def of(name: str):
        splits = load_dataset(str(small.made), name, cache_dir=str(cache))
        pictures = [column.name for column in TABLES[name].columns if column.kind == "image"]
        for picture in pictures:
            assert all(isinstance(rows.features[picture], Picture) for rows in splits.values())
            splits = splits.cast_column(picture, Picture(decode=False))
        return {split: rows.to_list() for split, rows in splits.items()}

    return of


def files(folder: Path) -> dict[str, bytes]:
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def front_matter(folder: Path) -> dict:
    return yaml.safe_load((folder / "README.md").read_text(encoding="utf-8").split("---\n")[1])


def tours_of(small: Small):
    """Each recorded tour by its id, with its directory and the lens."""
    cache = TourCache(small.cache, pytest.fail)
    for episode in small.every:
        with Session(episode.scene, episode.settings) as session:
            for which in VISITS:
                place = cache.places(session, episode)[episode.visits[which]]
                yield tour_id(episode, which), place, episode.protocol.camera.field_of_view_deg


def test_episodes_are_their_records(small, loaded):
    rows = loaded("episodes")
    assert {split: [Episode.parse(row["truth_record"]) for row in of] for split, of in rows.items()} == small.episodes
    for episode, row in zip(small.every, [row for of in rows.values() for row in of], strict=True):
        record = episode.to_json()
        assert (row["episode"], row["split"], row["sentence"]) == (episode.id, episode.split, episode.sentence)
        assert (row["category"], row["relation"]) == (episode.query.category, episode.query.relation)
        assert (row["truth_answer_x"], row["truth_answer_z"]) == episode.answer
        assert (row["spawn_x"], row["spawn_z"], row["spawn_yaw_deg"]) == (*record["spawn"].values(),)
        assert json.loads(row["truth_changes"]) == record["changes"] and row["truth_changed"] == len(record["changes"])
        assert json.loads(row["protocol"]) == {name: record["protocol"][name] for name in ("camera", "primitives")}
        box = [row[f"reachable_{axis}_{end}"] for axis in "xz" for end in ("min", "max")]
        assert box == [*record["reachable_box"]["x"], *record["reachable_box"]["z"]]


def test_what_is_no_truth_says_none(small, loaded):
    """Without the columns of truth no instance is named, nor is where one was, and no name of a visit that says what changed."""
    for episode, row in zip(small.every, [row for of in loaded("episodes").values() for row in of], strict=True):
        shown = {name: value for name, value in row.items() if not name.startswith("truth_")}
        texts = [value for value in shown.values() if isinstance(value, str)]
        for secret in (episode.target, *episode.changed, *episode.visits.model_dump().values()):
            assert not [text for text in texts if secret in text]
    assert not [column.name for column in TOURS.columns if column.is_truth]
    secrets = {name for episode in small.every for name in (*episode.changed, *episode.visits.model_dump().values(), episode.id)}
    for file in (small.made / "tours").rglob("*.parquet"):
        content = file.read_bytes()
        assert not [secret for secret in secrets if secret.encode() in content]


def test_tours_are_what_an_agent_is_given(small, loaded):
    rows = {split: {(row["tour"], row["view"]): row for row in of} for split, of in loaded("tours").items()}
    by_tour = {key: row for of in rows.values() for key, row in of.items()}
    seen, sensed = set(), 0
    for tour, place, lens in tours_of(small):
        for number, view in enumerate(load_visit(place, lens, np.empty((0, 2))).observations):
            row = by_tour[tour, number]
            seen.add((tour, number))
            assert (np.asarray(Image.open(io.BytesIO(row["rgb"]["bytes"]))) == view.rgb).all()
            depth = Image.open(io.BytesIO(row["depth"]["bytes"]))
            assert depth.mode == "I;16" and (np.asarray(depth) / np.float32(1000) == view.depth).all()
            pose = view.pose
            told = [row[name] for name in ("camera_x", "camera_y", "camera_z", "yaw_deg", "horizon_deg")]
            assert told == [pose.x, pose.y, pose.z, pose.yaw_deg, pose.horizon_deg]
            assert row["vertical_field_of_view_deg"] == view.field_of_view_deg
            assert (row["height_px"], row["width_px"]) == view.depth.shape
        looks = json.loads(contents(place)["visit.json"])["views"]
        sensed += sum(look["sensed"] is not None and look["sensed"]["camera"] != look["camera"] for look in looks)
    assert seen == by_tour.keys() and sensed, "every row is a view, and of some the sensed pose is not the true one"
    for split, some in small.episodes.items():
        named = [tour_id(episode, which) for episode in some for which in VISITS]
        assert [*dict.fromkeys(tour for tour, _ in rows[split])] == [*dict.fromkeys(named)]


@pytest.mark.parametrize("lens", [(300, 300, 90.0), (640, 480, 58.0), (90, 160, 120.0)])
def test_the_cards_formula_is_the_benchmarks(lens):
    width, height, angle = lens
    of = intrinsics(Lens(width_px=width, height_px=height, field_of_view_deg=angle))
    rng = np.random.default_rng(0)
    depth = rng.uniform(0.1, 9, (height, width))
    rows, columns = rng.integers(0, height, 50), rng.integers(0, width, 50)
    u, v, d = columns + 0.5, rows + 0.5, depth[rows, columns]
    points = np.stack([(u - of["cx"]) / of["fx"] * d, (of["cy"] - v) / of["fy"] * d, d], axis=1)
    assert np.allclose(points, pixel_points(depth, rows, columns, Camera((0.0, 0.0, 0.0), 0.0, 0.0, angle)), atol=1e-6)


def test_predictions_and_runs_are_their_records(small, loaded):
    nested = {column.name for table in (PREDICTIONS, RUNS) for column in table.columns if column.kind == "json"}
    splits = {episode.id: episode.split for episode in small.every}
    for table, folder, of, schema in (
        ("predictions", "predictions", Prediction, "ovman-prediction/1"),
        ("runs", "scores", Score, "ovman-run/1"),
    ):
        found = []
        for split, row in ((split, row) for split, rows in loaded(table).items() for row in rows):
            values = {name: json.loads(value) if name in nested and value else value for name, value in row.items()}
            assert values.pop("split") == split == splits[row["episode"]]
            if table == "runs":
                stop = {axis: values.pop(f"stop_{axis}") for axis in ("x", "z", "yaw_deg")}
                values["stop"] = stop if stop["x"] is not None else None
            found.append(of.from_json(values | {"schema": schema}))
        assert sorted(found, key=str) == small.records(folder, of) and found


@pytest.mark.parametrize(("table", "of"), [(PREDICTIONS, Prediction), (RUNS, Score)])
def test_every_field_of_a_record_has_a_column(table, of):
    fields = {field.alias or name for name, field in of.model_fields.items()} - {"schema", "stop"}
    assert fields <= {column.name for column in table.columns}
    with pytest.raises(ValueError, match="values without a column"):
        table.row({column.name: None for column in table.columns} | {"another": 1})


def test_croissant_is_valid_and_streams_every_record(small, loaded):
    said = json.loads((small.made / "croissant.json").read_text(encoding="utf-8"))
    assert all(said[f"rai:{name}"] for name in ASKED) and said["prov:wasDerivedFrom"] and said["prov:wasGeneratedBy"]
    found = mlcroissant.Dataset(str(small.made / "croissant.json"))
    assert not found.metadata.ctx.issues.errors
    assert [warning for warning, _ in found.metadata.ctx.issues._warnings if "datePublished" not in warning] == []
    for table in TABLES.values():
        rows = [row for of in loaded(table.name).values() for row in of]
        streamed = list(found.records(table.name))
        assert len(streamed) == len(rows) > 0

        def key(row: dict, columns=table.columns):
            flat = [row[column.name] for column in columns if column.kind != "image"]
            return str([value.decode() if isinstance(value, bytes) else value for value in flat])

        told = [{name.partition("/")[2]: value for name, value in one.items()} for one in streamed]
        assert sorted(map(key, told)) == sorted(map(key, rows))
        for picture in (column.name for column in table.columns if column.kind == "image"):
            assert {one[picture].size for one in told} == {(row["width_px"], row["height_px"]) for row in rows}


def test_every_column_has_a_meaning_with_its_unit_in_the_card_and_in_croissant(small):
    card = (small.made / "README.md").read_text(encoding="utf-8")
    said = json.loads((small.made / "croissant.json").read_text(encoding="utf-8"))
    fields = {field["@id"]: field["description"] for one in said["recordSet"] for field in one["field"]}
    units = {"_m": "metres", "_deg": "degrees", "_px": "pixels"}
    for name, column in ((table.name, column) for table in TABLES.values() for column in table.columns):
        assert len(column.about.split()) > 1 and f" {column.about} " in card, column
        assert fields[f"{name}/{column.name}"].endswith(column.about), column
        assert all(unit in column.about for suffix, unit in units.items() if column.name.endswith(suffix)), column
        assert column.kind != "number" or any(unit in column.about for unit in (*units.values(), "0 to 1")), column


def test_the_card_and_the_checksums_name_what_is_there(small):
    patterns = [entry["path"] for config in front_matter(small.made)["configs"] for entry in config["data_files"]]
    named = {path.relative_to(small.made).as_posix() for pattern in patterns for path in small.made.glob(pattern)}
    there = {*files(small.made)}
    assert named == {name for name in there if name.endswith(".parquet")}
    assert {line.split("  ")[1] for line in (small.made / SUMS).read_text().splitlines()} == there - {SUMS}


def code(text: str, language: str) -> list[str]:
    """The blocks of code of a card."""
    return re.findall(rf"^```{language}\n(.*?)^```$", text, re.DOTALL | re.MULTILINE)


def test_every_line_of_code_of_the_card_runs_as_it_is_printed(small, tmp_path, monkeypatch):
    monkeypatch.setattr("datasets.config.HF_DATASETS_CACHE", tmp_path)
    for folder, blocks in ((small.made, 2), (ROOT / "dataset", 1)):
        monkeypatch.chdir(folder)
        text, names = (folder / "README.md").read_text(encoding="utf-8"), {}
        programs, commands = code(text, "python"), "".join(code(text, "sh")).splitlines()
        for program in programs[:blocks]:  # the checkout has no tours
            exec(program, names)
        assert len(programs) == 1 + ("tours/" in text) and len(names["episodes"]) > 0
        for command in commands:
            if command.startswith("pip install "):
                assert all(find_spec({"pillow": "PIL"}.get(name, name)) for name in command.split()[2:])
            else:
                subprocess.run(command, shell=True, check=True)
        if blocks == 2:
            assert names["first"][0]["rgb"].size == names["first"][0]["depth"].size


def test_without_tours_nothing_says_that_there_are_some(small, tmp_path, monkeypatch):
    copy = tmp_path / "copy"
    shutil.copytree(small.made, copy)
    monkeypatch.setattr(Session, "__enter__", lambda _: pytest.fail("a simulator was started"))
    assert small.make(copy, "--without-tours", "--split", "everyday") == 0
    assert {name for name in files(copy) if name.endswith(".parquet")} == {
        f"{table.name}/everyday.parquet" for table in TABLES.values() if table is not TOURS
    }
    assert [config["config_name"] for config in front_matter(copy)["configs"]] == ["episodes", "runs", "predictions"]
    assert files(copy)["runs/everyday.parquet"] == files(small.made)["runs/everyday.parquet"]


@pytest.fixture
def visits(small, tmp_path) -> Path:
    """The recorded tours as the workflow keeps them."""
    above = tmp_path / "visits"
    for scene in {episode.scene for episode in small.every}:
        (above / scene).mkdir(parents=True)
        for place in (small.cache / "tours" / scene).glob("*/*.zip"):
            shutil.copy(place, above / scene)
        found = {place.stem: VisitFiles.load(place).content for place in (above / scene).iterdir()}
        (above / f"{scene}.json").write_text(VisitManifest(scene=scene, visits=found).to_line(), encoding="utf-8")
    return above


def test_tours_that_the_workflow_recorded_are_taken(small, visits, tmp_path):
    nothing = tmp_path / "cache"
    assert small.make(tmp_path / "out", "--visits", str(visits), "--cache", str(nothing)) == 0
    assert files(tmp_path / "out") == files(small.made) and not nothing.exists()


def test_a_damaged_tour_is_no_row(small, visits, tmp_path, capsys):
    tour = tour_path(visits / SCENE, small.every[0].visits.second)
    rewrite(tour, {"03_depth.png": contents(tour)["03_depth.png"][:-1] + b"\0"}, sealed=False)
    assert small.make(tmp_path / "out", "--visits", str(visits)) == 1
    (said,) = capsys.readouterr().err.splitlines()
    assert str(tour) in said and "03_depth.png is not what was recorded" in said
    assert not [*(tmp_path / "out").rglob(f"*{SCENE}*")], "a file is whole or not there"
    assert small.make(tmp_path / "out") == 0, "an interrupted making is made again"


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--split", "nowhere"], "--split: nowhere is no split; write one of "),
        (["--split", "multi"], "the release has no episodes of the split multi"),
        (["--out", str(ROOT / "ovman")], "holds other files and no croissant.json; name a new folder with --out"),
    ],
)
def test_what_is_wrong_is_said_in_a_line(small, tmp_path, capsys, options, says):
    assert small.make(tmp_path / "out", *options) == 1
    (said,) = capsys.readouterr().err.splitlines()
    assert said.startswith("ovman dataset: ") and says in said


def test_without_arrow_the_command_says_what_to_install(monkeypatch, capsys):
    for name in ("making", "metadata", "tables"):
        monkeypatch.delitem(sys.modules, f"ovman.dataset.{name}")
    monkeypatch.delattr("ovman.dataset.making")
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert main(["dataset", "--out", "none"]) == 1
    assert (
        capsys.readouterr().err == "ovman dataset: pyarrow is not installed; in a checkout of OVMAN: pip install '.[dataset]'\n"
    )
