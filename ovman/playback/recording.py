"""An episode as a Rerun recording, .rrd: both visits side by side, what is where, what arms answer, and how they drive.

Coordinates are the benchmark's, Unity's: metres, left-handed, y up. The timeline `view` is that of the tours, `action` that of
the runs. Entities: `first/` and `second/` are the visits, `truth/` is what agents are never told, `arms/` what they made of it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ovman.agents.interface import VISITS, Observation
from ovman.evaluation.recorded_tour import recorded
from ovman.perception.backprojection import Camera, world_points
from ovman.records.episode import Episode
from ovman.records.prediction import Answer
from ovman.records.scene import Scene
from ovman.report.show.reasoning import Reasoning
from ovman.report.show.verdicts import Drive, StaticRow
from ovman.settings import Settings

STRIDE = 4
"""Of the pixels of a frame, each this many in a row and a column become points."""
POINT_M, PATH_M = 0.012, 0.015
CIRCLE = 48
TRUTH, FIRST, SECOND, FOUND, MISSED = [156, 47, 116], [84, 39, 143], [8, 69, 130], [0, 115, 92], [194, 80, 10]
OBJECT_M, ANSWER_M, STOP_M = 0.9, 0.06, 0.12
"""Heights at which what has a place on the floor plane alone is drawn."""


def write(
    path: Path,
    episode: Episode,
    scene: Scene,
    tours: Mapping[str, Path],
    reasonings: Sequence[Reasoning],
    answers: Sequence[StaticRow],
    paths: Sequence[Drive],
    settings: Settings,
) -> None:
    """Write the recording of an episode. tours: folders of its recorded visits by "first" and "second", shown as agents are told.

    ModuleNotFoundError where Rerun is not installed.
    """
    import rerun as rr

    recording = rr.RecordingStream("ovman", recording_id=episode.id, send_properties=False)
    recording.save(str(path), default_blueprint=_layout())
    recording.disable_timeline("log_tick")
    recording.disable_timeline("log_time")
    recording.log("/", rr.ViewCoordinates.RUF, static=True)
    recording.log("about", rr.TextDocument(_words(episode, answers, paths), media_type="text/markdown"), static=True)
    _truth(rr, recording, episode, scene, settings.success.radius_m)
    for which, directory in tours.items():
        visit = recorded(directory, settings.camera.field_of_view_deg, np.empty((0, 2)))
        _tour(rr, recording, which, visit.observations)
    for reasoning in reasonings:
        _objects(rr, recording, reasoning)
    for row in answers:
        _answer(rr, recording, row)
    for one in paths:
        _path(rr, recording, one)
    recording.flush()


def _layout() -> Any:
    import rerun.blueprint as rrb

    views = [
        rrb.Vertical(
            rrb.Spatial3DView(origin="/", contents=[f"/{which}/**", "/truth/**", "/arms/**"], name=f"{which} visit"),
            rrb.Spatial2DView(origin=f"/{which}/camera", name=f"{which} visit, frames"),
            row_shares=[3, 2],
        )
        for which in VISITS
    ]
    return rrb.Blueprint(
        rrb.Horizontal(*views, rrb.TextDocumentView(origin="/about", name="episode"), column_shares=[3, 3, 2]),
        rrb.TimePanel(timeline="view"),
    )


def _words(episode: Episode, answers: Sequence[StaticRow], paths: Sequence[Drive]) -> str:
    lines = [f"# {episode.sentence}", "", f"{episode.id}, {episode.split}", "", "| arm | verdict |", "|---|---|"]
    lines += [f"| {row.letter} {row.arm.name} | {row.words or row.verdict} |" for row in answers]
    lines += [
        f"| {one.run.arm}, seed {one.run.seed} | {one.run.outcome}, {'success' if one.run.success else 'failure'} |"
        for one in paths
    ]
    return "\n".join(lines)


def _truth(rr: Any, recording: Any, episode: Episode, scene: Scene, radius_m: float) -> None:
    x, z = episode.answer
    floor = scene.floor_y
    turns = np.linspace(0.0, 2.0 * math.pi, CIRCLE + 1)
    circle = np.column_stack([x + radius_m * np.cos(turns), np.full(CIRCLE + 1, floor + ANSWER_M), z + radius_m * np.sin(turns)])
    recording.log(
        "truth/answer", rr.Points3D([[x, floor + ANSWER_M, z]], colors=[TRUTH], radii=[0.05], labels=["answer"]), static=True
    )
    recording.log("truth/success_radius", rr.LineStrips3D([circle], colors=[TRUTH], radii=[0.008]), static=True)
    sizes = {thing.id: thing.size for thing in scene.objects}
    for which, world in zip(VISITS, (episode.world_1, episode.world_2), strict=True):
        there = [(thing.id, thing.position) for thing in world if thing.id in sizes]
        if there:
            recording.log(
                f"{which}/truth/instances",
                rr.Boxes3D(
                    centers=[[at[0], floor + sizes[name].y / 2, at[1]] for name, at in there],
                    sizes=[[sizes[name].x, sizes[name].y, sizes[name].z] for name, _ in there],
                    colors=[TRUTH if name == episode.target else [150, 150, 150] for name, _ in there],
                    labels=[name for name, _ in there],
                ),
                static=True,
            )
    moves = [
        [[one.before.x, one.before.y, one.before.z], [one.after.x, one.after.y, one.after.z]]
        for one in episode.changes
        if one.before is not None and one.after is not None
    ]
    if moves:
        recording.log("truth/moves", rr.LineStrips3D(moves, colors=[TRUTH], radii=[PATH_M]), static=True)
    cells = np.array([[cx, floor, cz] for cx, cz in scene.reachable])
    recording.log("truth/reachable", rr.Points3D(cells, colors=[[200, 200, 200]], radii=[0.01]), static=True)


def _tour(rr: Any, recording: Any, which: str, frames: Sequence[Observation]) -> None:
    for number, frame in enumerate(frames):
        assert frame.rgb is not None and frame.depth is not None, "a recorded tour has pictures"
        at = frame.pose
        camera = Camera((at.x, at.y, at.z), at.yaw_deg, at.horizon_deg, frame.field_of_view_deg)
        height, width = frame.depth.shape
        recording.set_time("view", sequence=number)
        right, up, forward = camera.axes()
        recording.log(
            f"{which}/camera",
            rr.Transform3D(translation=[at.x, at.y, at.z], mat3x3=np.column_stack([right, up, forward])),
            rr.Pinhole(
                fov_y=math.radians(frame.field_of_view_deg),
                aspect_ratio=width / height,
                width=width,
                height=height,
                camera_xyz=rr.ViewCoordinates.RUF,
                image_plane_distance=0.3,
            ),
        )
        recording.log(f"{which}/camera/rgb", rr.Image(frame.rgb).compress(jpeg_quality=85))
        taken = np.zeros((height, width), bool)
        taken[::STRIDE, ::STRIDE] = True
        recording.log(
            f"{which}/points/{number:02d}",
            rr.Points3D(world_points(frame.depth, taken, camera), colors=frame.rgb[taken], radii=[POINT_M]),
        )


def _objects(rr: Any, recording: Any, reasoning: Reasoning) -> None:
    base = f"arms/{reasoning.arm}"
    places: list[dict[int, list[float]]] = [
        {item.id: [item.at[0], OBJECT_M, item.at[1]] for item in reasoning.grounded(visit)} for visit in (0, 1)
    ]
    for visit, colour in enumerate((FIRST, SECOND)):
        if places[visit]:
            recording.log(
                f"{base}/grounded_{VISITS[visit]}",
                rr.Points3D(
                    [*places[visit].values()], colors=[colour], radii=[0.06], labels=[f"{name}" for name in places[visit]]
                ),
                static=True,
            )
    joined = [
        [places[0][pair.first], places[1][pair.second]]
        for pair in reasoning.pairs
        if pair.first in places[0] and pair.second in places[1]
    ]
    if joined:
        recording.log(f"{base}/pairs", rr.LineStrips3D(joined, colors=[SECOND], radii=[PATH_M]), static=True)


def _answer(rr: Any, recording: Any, row: StaticRow) -> None:
    outcome = row.outcome
    if isinstance(outcome, Answer):
        colour = FOUND if row.verdict == "found" else MISSED
        name = row.arm.name if row.run is None else f"{row.arm.name}/run{row.run}"
        recording.log(
            f"arms/{name}/answer",
            rr.Points3D([[outcome.x, STOP_M, outcome.z]], colors=[colour], radii=[0.07], labels=[row.arm.name]),
            static=True,
        )


def _path(rr: Any, recording: Any, one: Drive) -> None:
    base = f"arms/{one.run.arm}/seed{one.run.seed}"
    colour = FOUND if one.run.success else MISSED
    line = [[x, STOP_M, z] for x, z, _ in one.poses]
    recording.log(f"{base}/path", rr.LineStrips3D([line], colors=[colour], radii=[PATH_M]), static=True)
    recording.log(
        f"{base}/end",
        rr.Points3D(line[-1:], colors=[colour], radii=[0.06], labels=[f"{one.run.arm}, seed {one.run.seed}"]),
        static=True,
    )
    for number, (x, z, yaw) in enumerate(one.poses):
        recording.set_time("action", sequence=number)
        heading = [math.sin(math.radians(yaw)) * 0.25, 0.0, math.cos(math.radians(yaw)) * 0.25]
        recording.log(f"{base}/agent", rr.Arrows3D(origins=[[x, STOP_M, z]], vectors=[heading], colors=[colour], radii=[0.02]))
