"""The tables of the data set and their rows. tables.yaml describes the columns for Arrow, Hugging Face, Croissant and the card.

Columns that begin with `truth_` are for the evaluator alone. The table of tours has none: it holds what an agent sees in both
visits, without query, instance, mask, light and seed, and with the sensed pose where it differs from the true one.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow
import yaml
from pyarrow import parquet

from ovman.agents.interface import VISITS
from ovman.atomic import clear_partials, replacing
from ovman.cache import digest
from ovman.perception.tour_files import PICTURES, cameras
from ovman.records.episode import Episode
from ovman.records.prediction import Prediction
from ovman.records.run import Score
from ovman.records.visit import VisitFiles, picture_name, read_verified
from ovman.settings.benchmark import Camera

TRUTH = "truth_"
"""How the names of columns begin that only the evaluator may read."""
TOLD = ("camera", "primitives")
"""Sections of the protocol that an agent is told."""
ARROW = {"text": "string", "json": "string", "integer": "int64", "number": "float64", "flag": "bool"}
"""Arrow's and Hugging Face's name of each kind of column but "image", the bytes of a PNG. "json" is text with one JSON value."""
IMAGE = pyarrow.struct([("bytes", pyarrow.binary()), ("path", pyarrow.string())])
"""As `datasets.Image` stores a picture."""


@dataclass(frozen=True, slots=True)
class Column:
    """A column. kind: of ARROW, or "image"; about: its content, with unit and frame."""

    name: str
    kind: str
    about: str

    @property
    def is_truth(self) -> bool:
        """Whether only the evaluator may read it."""
        return self.name.startswith(TRUTH)


@dataclass(frozen=True, slots=True)
class Table:
    """A configuration of the data set. about: what a row is."""

    name: str
    about: str
    columns: tuple[Column, ...]

    @property
    def has_pictures(self) -> bool:
        """Whether rows hold pictures; such a table has a file per floor plan."""
        return any(column.kind == "image" for column in self.columns)

    def file(self, split: str, part: str = "") -> str:
        """Return the name of a file of a split; part: the floor plan in a table with pictures. "*" makes a pattern."""
        return f"{self.name}/{split}/{part}.parquet" if self.has_pictures else f"{self.name}/{split}.parquet"

    def row(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the values in the order of the columns. Raises ValueError for a column or a value without the other."""
        if wrong := {column.name for column in self.columns} ^ set(values):
            raise ValueError(f"table {self.name}: {sorted(wrong)} are columns without a value, or values without a column")
        return {
            column.name: _to_json(values[column.name]) if column.kind == "json" else values[column.name]
            for column in self.columns
        }

    def write(self, groups: Iterable[Iterable[dict[str, Any]]], file: Path) -> int:
        """Write rows, a row group per group, and return their number. Equal rows are equal bytes under one version of pyarrow.

        One group is held at a time. The file is whole or absent.
        """
        features = {
            column.name: {"_type": "Image"} if column.kind == "image" else {"dtype": ARROW[column.kind], "_type": "Value"}
            for column in self.columns
        }
        schema = pyarrow.schema(
            [(c.name, IMAGE if c.kind == "image" else pyarrow.type_for_alias(ARROW[c.kind])) for c in self.columns],
            metadata={"huggingface": json.dumps({"info": {"features": features}}, separators=(",", ":"))},
        )
        flat = [column.name for column in self.columns if column.kind != "image"]
        compression = "none" if self.has_pictures else "zstd"  # a PNG is compressed already
        count = 0
        clear_partials(file)
        with (
            replacing(file) as partial,
            parquet.ParquetWriter(partial, schema, compression=compression, use_dictionary=flat, write_statistics=flat) as writer,
        ):
            for rows in groups:
                group = pyarrow.Table.from_pylist([*rows], schema=schema)
                writer.write_table(group, row_group_size=max(1, len(group)))
                count += len(group)
        return count


def _to_json(value: Any) -> str | None:
    return None if value is None else json.dumps(value, separators=(",", ":"), ensure_ascii=False, allow_nan=False)


def _read_tables() -> dict[str, Table]:
    described = yaml.safe_load(Path(__file__).with_name("tables.yaml").read_text(encoding="utf-8"))
    return {
        name: Table(name, one["about"], tuple(Column(column, *of) for column, of in one["columns"].items()))
        for name, one in described.items()
    }


TABLES = _read_tables()
"""By name, in the order of the card; the first is the default configuration."""
EPISODES, TOURS, RUNS, PREDICTIONS = (TABLES[name] for name in ("episodes", "tours", "runs", "predictions"))


@dataclass(frozen=True, slots=True)
class Tour:
    """A tour to be written: its id, and an episode with the visit, "first" or "second", that it belongs to."""

    id: str
    episode: Episode
    which: str


def tour_id(episode: Episode, which: str) -> str:
    """Return the id of the tour of the visit "first" or "second", which is equal for equal tours of episodes.

    The visit's own name says what was changed in it, so the id is a digest.
    """
    tour, camera = episode.tours[which].to_json(), episode.protocol.camera.model_dump(mode="json")
    return digest(episode.backend, episode.provenance.seed, episode.scene, episode.visits[which], tour, camera)[:16]


def list_tours(episodes: Sequence[Episode]) -> dict[str, list[Tour]]:
    """Return the tours of episodes by floor plan, each once: floor plans by name, tours in the order of the episodes."""
    found: dict[str, dict[str, Tour]] = {scene: {} for scene in sorted({episode.scene for episode in episodes})}
    for episode in episodes:
        for which in VISITS:
            tour = Tour(tour_id(episode, which), episode, which)
            found[episode.scene].setdefault(tour.id, tour)
    return {scene: [*tours.values()] for scene, tours in found.items()}


def episode_rows(episodes: Sequence[Episode]) -> Iterator[dict[str, Any]]:
    """Yield one row per episode, in their order."""
    for episode in episodes:
        record, box, (x, z) = episode.to_json(), episode.reachable_box, episode.answer
        yield EPISODES.row(
            {name: record[name] for name in ("split", "backend", "scene", "sentence", "noun", "category", "relation")}
            | {"episode": episode.id}
            | {f"{which}_tour": tour_id(episode, which) for which in VISITS}
            | {f"spawn_{name}": record["spawn"][name] for name in ("x", "z", "yaw_deg")}
            | {"reachable_x_min": box.x[0], "reachable_x_max": box.x[1]}
            | {"reachable_z_min": box.z[0], "reachable_z_max": box.z[1]}
            | {"protocol": {name: record["protocol"][name] for name in TOLD}}
            | {"truth_target": episode.target, "truth_distractor": episode.distractor}
            | {"truth_answer_x": x, "truth_answer_z": z}
            | {"truth_navigable_x": episode.nearest_navigable[0], "truth_navigable_z": episode.nearest_navigable[1]}
            | {"truth_shortest_path_m": episode.shortest_path_m, "truth_instances": episode.instances_in_category}
            | {"truth_changed": len(episode.changed), "truth_changes": record["changes"]}
            | {"truth_world_1": record["world_1"], "truth_world_2": record["world_2"], "truth_record": record}
        )


def tour_rows(tour: Tour, file: Path) -> Iterator[dict[str, Any]]:
    """Yield one row per view of a recorded tour, its pictures byte for byte as recorded. Raises TourError for a damaged file."""
    camera = tour.episode.protocol.camera
    files = VisitFiles.load(file)
    for number, view in enumerate(cameras(file, camera.field_of_view_deg)):
        pictures = {kind: read_verified(file, picture_name(number, kind), files) for kind in PICTURES}
        x, y, z = view.position
        yield TOURS.row(
            {"tour": tour.id, "scene": tour.episode.scene, "view": number}
            | {kind: {"bytes": content, "path": None} for kind, content in pictures.items()}
            | {"camera_x": x, "camera_y": y, "camera_z": z, "yaw_deg": view.yaw_deg, "horizon_deg": view.horizon_deg}
            | intrinsics(camera)
        )


def intrinsics(camera: Camera) -> dict[str, float]:
    """Return the size, vertical field of view, focal lengths and principal point of a camera with square pixels.

    Focal lengths are rounded to 1e-6 of a pixel, so that their bytes do not depend on the processor's last bit.
    """
    focal = round(camera.height_px / 2 / math.tan(math.radians(camera.field_of_view_deg) / 2), 6)
    return {
        "width_px": camera.width_px,
        "height_px": camera.height_px,
        "vertical_field_of_view_deg": camera.field_of_view_deg,
        "fx": focal,
        "fy": focal,
        "cx": camera.width_px / 2,
        "cy": camera.height_px / 2,
    }


def read_answers(folder: Path, splits: Mapping[str, str]) -> dict[str, list[dict[str, Any]]]:
    """Return the rows of the predictions or the runs below a folder by split, sorted by arm, run and episode.

    splits: the splits of the episodes that count, by their ids, in order.
    """
    table, kind = (PREDICTIONS, Prediction) if folder.name == PREDICTIONS.name else (RUNS, Score)
    place = {episode: number for number, episode in enumerate(splits)}
    every: list[Any] = [one for file in sorted(folder.rglob("*.jsonl")) for one in kind.read(file) if one.episode in place]
    every.sort(key=lambda record: (record.arm, record.seed, place[record.episode]))
    found: dict[str, list[dict[str, Any]]] = {split: [] for split in splits.values()}
    for record in every:
        found[splits[record.episode]].append(answer_row(table, record.to_json(), splits[record.episode]))
    return {split: rows for split, rows in found.items() if rows}


def answer_row(table: Table, record: dict[str, Any], split: str) -> dict[str, Any]:
    """Return the row of a prediction or a run; columns that the record does not mention are empty."""
    values = dict.fromkeys(column.name for column in table.columns) | record | {"split": split}
    del values["schema"]
    if table is RUNS:
        values |= {f"stop_{name}": at for name, at in (values.pop("stop") or {}).items()}
    return table.row(values)
