"""Training pictures: views of a scene from random poses, with randomised finishes, lights and clutter, and their files.

A scene's folder has `images/0000.png`, `labels/0000.txt` (outlines, as ultralytics reads them), `ids/0000.png` (16 bit; 0 is
nothing, k the k-th object of this picture) and `objects.jsonl` (one line per picture).
"""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ovman.seeds import generator
from ovman.settings import Settings
from ovman.sim import controller
from ovman.sim.embodiment import Embodiment
from ovman.sim.images import write_png
from training.floorplans import load_place

VIEWS_A_DRAW = 8
"""Views of a scene between two randomisations."""
HORIZONS_DEG, HORIZON_SHARES = (0.0, 15.0, 30.0, 60.0, -15.0), (0.6, 0.1, 0.2, 0.05, 0.05)
"""The camera's pitch and its probabilities. Tours look straight ahead, the look-down sweep 30 and 60 degrees down."""
HEIGHTS_M, RAISED = (-0.7, 0.3), 0.4
"""Range of the camera's extra height, in this share of the views."""
CLUTTER = 0.5
"""Share of the randomisations that move pickupable objects."""
EMPTY = 0.25
"""Share of the views with fewer than two objects that are kept."""
TAKEN = 0.15
"""Share of the movable objects that a randomisation removes."""
RANDOMISED_LOOKS = 0.7
"""Share of the randomisations that change finishes and lights."""
UNSEEN = frozenset(["Floor"])
"""Types that are not instances."""
MIN_MASK_PX = 80
"""Smallest instance in the detector's training data."""
SPECK_PX = 20
"""Smaller pieces of an instance are dropped from its outline."""


@dataclass(frozen=True, slots=True)
class ShownObject:
    """An object in a picture: type, asset and materials by AI2-THOR's names, and the size of its box along x, y and z, metres."""

    type: str
    asset: str
    materials: tuple[str, ...]
    size_m: tuple[float, float, float]


@dataclass(frozen=True, slots=True, eq=False)
class Picture:
    """One view. rgb: (H, W, 3) uint8; ids: (H, W) int16, indices into objects, or -1."""

    rgb: np.ndarray
    ids: np.ndarray
    objects: tuple[ShownObject, ...]

    def sizes(self) -> np.ndarray:
        """Return the number of pixels of each object."""
        return np.bincount(self.ids[self.ids >= 0], minlength=len(self.objects))


@dataclass(frozen=True, slots=True)
class RecordedPicture:
    """One picture on disk: its folder and its number in the scene."""

    folder: Path
    number: int

    @property
    def image(self) -> Path:
        """The file of its RGB image."""
        return self.folder / "images" / f"{self.number:04d}.png"


def run(scene: str, is_held_out: bool, settings: Settings, output: Path) -> None:
    """Record the pictures of a scene into the folder `output`.

    Their number is training.views or training.held_out_views for a floor plan, and training.home_views for a home.
    """
    training = settings.training
    views, place = training.held_out_views if is_held_out else training.views, load_place(scene)
    if not isinstance(place, str):
        views = training.home_views
    simulator = controller.start(settings.benchmark.backend, place, Embodiment.of(settings))
    try:
        rng = generator(training.seed, "pictures", scene)
        left_out = () if is_held_out else training.left_out
        count = write_pictures(output, take_pictures(simulator, place, views, rng, left_out))
    finally:
        simulator.stop()
    print(f"{scene}: {count} pictures", flush=True)


def take_pictures(
    controller: Any, scene: str | dict[str, Any], count: int, rng: np.random.Generator, left_out: Collection[str] = ()
) -> Iterator[Picture]:
    """Take `count` views of a scene on a running Controller with instance segmentation; equal for equal states of `rng`.

    Objects of the types `left_out` are removed from the scene first.
    """
    taken = 0
    while taken < count:
        controller.reset(scene, renderImage=False)
        for found in controller.last_event.metadata["objects"]:
            if found["objectType"] in left_out:
                controller.step("DisableObject", objectId=found["objectId"], renderImage=False)
        spots = _randomise(controller, rng, keep=taken == 0)
        for _ in range(min(VIEWS_A_DRAW, count - taken)):
            picture = _take_picture(controller, rng, spots)
            while len(picture.objects) < 2 and rng.random() > EMPTY:
                picture = _take_picture(controller, rng, spots)
            yield picture
            taken += 1


def _take_picture(controller: Any, rng: np.random.Generator, spots: list[dict[str, float]]) -> Picture:
    spot = spots[rng.integers(len(spots))]
    height = rng.uniform(*HEIGHTS_M) if rng.random() < RAISED else 0.0
    event = controller.step(
        "TeleportFull",
        position={**spot, "y": spot["y"] + height},
        rotation={"x": 0.0, "y": float(rng.uniform(0, 360)), "z": 0.0},
        horizon=float(rng.choice(HORIZONS_DEG, p=HORIZON_SHARES)),
        standing=True,
        forceAction=True,
    )
    if not event.metadata["lastActionSuccess"]:
        raise RuntimeError(f"a view was refused: {event.metadata['errorMessage']}")
    return picture_of(event)


def _randomise(controller: Any, rng: np.random.Generator, keep: bool) -> list[dict[str, float]]:
    """Randomise the scene, unless its own state is to be kept, and return where the agent can stand in it."""

    def step(action: str, **arguments: Any) -> Any:
        return controller.step(action, renderImage=False, **arguments)

    if not keep:
        step("SetRandomSeed", seed=int(rng.integers(2**31)))
        if rng.random() < RANDOMISED_LOOKS:
            step("RandomizeMaterials")
            step("RandomizeLighting", brightness=[0.5, 1.5], randomizeColor=True, hue=[0, 1], saturation=[0, 0.4])
        if rng.random() < CLUTTER:
            step("InitialRandomSpawn", randomSeed=int(rng.integers(2**31)), allowFloor=True)
        for found in controller.last_event.metadata["objects"]:
            if (found["pickupable"] or found["moveable"]) and rng.random() < TAKEN:
                step("DisableObject", objectId=found["objectId"])
    positions: list[dict[str, float]] = step("GetReachablePositions").metadata["actionReturn"]
    return positions


def picture_of(event: Any) -> Picture:
    """Return the picture of an event with RGB and instance segmentation."""
    frame = event.instance_segmentation_frame.astype(np.int32)
    code = frame[..., 0] << 16 | frame[..., 1] << 8 | frame[..., 2]
    values, inverse = np.unique(code, return_inverse=True)
    known = {o["objectId"]: o for o in event.metadata["objects"] if o["objectType"] not in UNSEEN}
    names = {c["color"][0] << 16 | c["color"][1] << 8 | c["color"][2]: c["name"] for c in event.metadata["colors"]}
    table = np.full(len(values), -1, np.int16)
    objects: list[ShownObject] = []
    for i, value in enumerate(values.tolist()):
        found = known.get(names.get(value, ""))
        if found is not None:
            table[i] = len(objects)
            size = found["axisAlignedBoundingBox"]["size"]
            materials = tuple(found["salientMaterials"] or ())
            objects.append(ShownObject(found["objectType"], found["assetId"], materials, (size["x"], size["y"], size["z"])))
    return Picture(event.frame.copy(), table[inverse].reshape(code.shape), tuple(objects))


def write_pictures(folder: Path, pictures: Iterable[Picture]) -> int:
    """Write pictures as they come and return their number."""
    for kind in ("images", "labels", "ids"):
        (folder / kind).mkdir(parents=True, exist_ok=True)
    count = 0
    with (folder / "objects.jsonl").open("w", encoding="utf-8") as objects:
        for count, picture in enumerate(pictures, start=1):
            name = f"{count - 1:04d}"
            write_png(folder / "images" / f"{name}.png", picture.rgb)
            write_png(folder / "ids" / f"{name}.png", (picture.ids + 1).astype(np.uint16))
            (folder / "labels" / f"{name}.txt").write_text("".join(f"{line}\n" for line in label_lines(picture.ids)))
            objects.write(json.dumps([asdict(shown) for shown in picture.objects], separators=(",", ":")) + "\n")
    return count


def list_pictures(folders: Sequence[Path], every: int = 1) -> list[RecordedPicture]:
    """List one of `every` pictures of each recorded folder."""
    return [
        RecordedPicture(folder, number)
        for folder in folders
        for number in range(0, len(list((folder / "images").glob("*.png"))), every)
    ]


def read_pictures(recorded: Sequence[RecordedPicture]) -> Iterator[Picture]:
    """Read pictures in their order. Raises OSError for a picture that cannot be read."""
    objects: dict[Path, list[str]] = {}
    for one in recorded:
        if one.folder not in objects:
            objects = {one.folder: (one.folder / "objects.jsonl").read_text(encoding="utf-8").splitlines()}
        lines = json.loads(objects[one.folder][one.number])
        shown = tuple(ShownObject(o["type"], o["asset"], tuple(o["materials"]), tuple(o["size_m"])) for o in lines)
        rgb = _read_png(one.image, cv2.IMREAD_COLOR)[..., ::-1]
        ids = _read_png(one.folder / "ids" / one.image.name, cv2.IMREAD_UNCHANGED)
        yield Picture(rgb, ids.astype(np.int16) - 1, shown)


def _read_png(path: Path, mode: int) -> np.ndarray:
    picture = cv2.imread(str(path), mode)
    if picture is None:
        raise OSError(f"{path}: not a readable picture; remove its folder and record the pictures again")
    return picture


def label_lines(ids: np.ndarray) -> list[str]:
    """Return the lines of a label file for ids (H, W): class 0, then the outline in fractions of the picture's sides."""
    height, width = ids.shape
    lines = []
    for number in range(int(ids.max()) + 1):
        mask = ids == number
        if mask.sum() < MIN_MASK_PX:
            continue
        polygon = outline(mask)
        if polygon is not None:
            points = (polygon + 0.5) / [width, height]
            lines.append("0 " + " ".join(f"{v:.4f}" for v in points.ravel()))
    return lines


def outline(mask: np.ndarray) -> np.ndarray | None:
    """Return one closed polygon (N, 2) in pixels around all pieces of a mask (H, W) bool, joined by seams; None for a speck."""
    pieces = [
        c[:, 0].astype(float)
        for c in cv2.findContours(mask.astype(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        if len(c) >= 3 and cv2.contourArea(c) >= SPECK_PX
    ]
    if not pieces:
        return None
    pieces.sort(key=len, reverse=True)
    whole = pieces[0]
    for piece in pieces[1:]:
        gaps = ((whole[:, None] - piece[None]) ** 2).sum(axis=2)
        i, j = np.unravel_index(gaps.argmin(), gaps.shape)
        turned = np.concatenate([piece[j:], piece[: j + 1]])
        whole = np.concatenate([whole[: i + 1], turned, whole[i:]])
    return _without_straight_points(whole)


def _without_straight_points(polygon: np.ndarray) -> np.ndarray:
    step = np.diff(np.concatenate([polygon[-1:], polygon, polygon[:1]]), axis=0)
    turns = (step[:-1] != step[1:]).any(axis=1)
    return polygon[turns] if turns.sum() >= 3 else polygon
