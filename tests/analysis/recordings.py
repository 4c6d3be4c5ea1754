"""A small recorded scene, written as the stages write theirs: three objects on a floor in front of a wall."""

from __future__ import annotations

import json

import numpy as np

from ovman.perception.records import Detected
from ovman.records.geometry import Position
from ovman.records.visit import RECORD, write_tour
from tests.episodes import scene_record
from tests.tour_zips import png

SIDE = 60
OBJECTS = {"Sofa|1": "Sofa", "Vase|1": "Vase", "Vase|2": "Vase", "Floor|1": "Floor"}
NAMES = ("Floor|1", "Sofa|1", "Vase|1", "Vase|2", "wall|1")
RECTANGLES = {"Floor|1": (40, 60, 0, 60), "Sofa|1": (10, 34, 4, 34), "Vase|1": (10, 30, 40, 58), "Vase|2": (36, 39, 40, 50)}
"""Rows and columns; all else is wall."""
MIN_MASK_PX = 50


def index_image():
    image = np.full((SIDE, SIDE), NAMES.index("wall|1") + 1, np.uint16)
    for name, (top, bottom, left, right) in RECTANGLES.items():
        image[top:bottom, left:right] = NAMES.index(name) + 1
    return image


def mask(name, shift=0):
    top, bottom, left, right = RECTANGLES[name]
    whole = np.zeros((SIDE, SIDE), bool)
    whole[top:bottom, left + shift : right + shift] = True
    return whole


def write_scene(path, name="FloorPlan1"):
    some, size = scene_record("FloorPlan1"), Position(x=0.8, y=1.0, z=0.6)
    objects = tuple(
        some.objects[0].model_copy(update={"id": k, "category": c, "position": Position(x=i, y=0.5, z=2.0), "size": size})
        for i, (k, c) in enumerate(OBJECTS.items())
    )
    path.mkdir(parents=True, exist_ok=True)
    (path / f"{name}.json").write_text(some.model_copy(update={"scene": name, "objects": objects}).to_line())
    return path / f"{name}.json"


def write_visit(file, views=2, alterations=(), moved=None, present=None):
    record = {
        "schema": "ovman-visit/2",
        "scene": file.parent.name,
        "visit": file.name,
        "alterations": list(alterations),
        "placed": {},
        "present": present or {},
        "movers": [],
        "views": [
            {
                "pose": {"x": 0.0, "z": 0.0, "yaw_deg": 0.0, "horizon_deg": 0.0},
                "camera": {"x": 0.0, "y": 1.0, "z": 0.0},
                "instances": list(NAMES),
                "seen": {},
                "moved": moved or {},
            }
        ]
        * views,
    }
    file, made = file.with_name(f"{file.name}.zip"), {RECORD: json.dumps(record).encode()}
    for view in range(views):
        made[f"{view:02d}_ids.png"] = png(index_image())
        made[f"{view:02d}_depth.png"] = png(np.full((SIDE, SIDE), 2000, np.uint16))
    write_tour(file, made)
    return file


def detected(masks, features=None, views=None, content="a", confidence=None, points=None):
    count = len(masks)
    seen = np.array(masks, bool).reshape(count, SIDE, SIDE)
    return Detected(
        view=np.zeros(count, int) if views is None else np.array(views),
        point=np.zeros((count, 3)) if points is None else np.array(points, float),
        feature=np.zeros((count, 4)) if features is None else np.array(features, float),
        pixels=seen.sum(axis=(1, 2)),
        confidence=np.linspace(0.9, 0.3, count) if confidence is None else np.array(confidence),
        masks=lambda: seen,
        content=content,
    )
