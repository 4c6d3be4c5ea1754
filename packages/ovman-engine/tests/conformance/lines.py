"""Lines of the engine's contract and the tests that stand for each: the table in docs/engine.md.

`python -m conformance.lines` writes it there.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "engine.md"
BEGIN, END = "<!-- contract -->", "<!-- end of contract -->"
NAMED = 3
"""Tests of a line that are named."""
LINES = {
    "1.1": "started as the client starts a Unity build, from a command with arguments and quoted blanks",
    "1.2": "heeds the environment that the client sets; headless means no images",
    "1.3": "the client's own traps: a missing DISPLAY, visible GPUs, an engine that cannot start",
    "1.4": "the first message comes unasked, then an answer to every action",
    "1.5": "frames of type, length and body; metadata first, images by agent, then by camera",
    "1.6": "sequence numbers come back; unchanged events are sent as patches",
    "1.7": "scenes, resets, sizes and initialisation in the order in which the client does them",
    "1.8": "a rotation may be a number; images can be asked for or left out action by action",
    "1.9": "all keys of the metadata, 42 of every object",
    "1.10": "RGB, metric planar depth, instance ids, classes and normals, bottom row first",
    "1.11": "a colour for every instance and class, with ids images alone",
    "1.12": "four error codes raise ValueError in the client; other failures are falsy events",
    "1.13": "a killed engine is noticed",
    "1.14": "ends when its client stops, dies or lets go; two run beside each other",
    "2 world": "left-handed metres and degrees, yaw clockwise from +z",
    "2 default agent": "capsule, eye height, field of view and planes of the default agent",
    "2 locobot": "capsule, eye height and noise of the LoCoBot",
    "2 start position": "agents start where AI2-THOR's do",
    "2 camera": "the picture of a camera at a pose, the right way up and round",
    "2 move test": "a move is free exactly if the capsule gets through",
    "2 reachable": "lattice positions that free moves lead to",
    "2 visibility": "near enough, in the picture and not hidden; schemes Collider and Distance",
    "2 objectId": "ids from type and start position; names that stay",
    "2 isMoving": "objects at rest, and scenes of them",
    "3 matching": "arguments are matched by name; what is refused changes nothing",
    "3 server actions": "actions of the old style take anything",
    "3 unknown": "InvalidAction",
    "3 missing": "MissingArguments",
    "3 superfluous": "InvalidArgument, with the ways to call the action",
    "3 unconvertible": "InvalidArgument, with the type that was wanted",
    "3 exception": "a failed event with the exception's name",
    "3 extra keys": "what every action accepts",
    "4 Initialize": "settings, images, planes, agent mode; out-of-range values are refused by name",
    "4 Reset": "the same world again",
    "4 MoveAhead": "a step along the heading, or the name of what is in the way",
    "4 MoveBack": "backwards",
    "4 MoveLeft": "sideways; not the LoCoBot",
    "4 MoveRight": "sideways; not the LoCoBot",
    "4 RotateLeft": "by any angle but 0",
    "4 RotateRight": "by any angle but 0",
    "4 LookUp": "up to the limit",
    "4 LookDown": "down to the limit",
    "4 Crouch": "the eye goes down; fails when down",
    "4 Stand": "the eye goes up; fails when up",
    "4 Teleport": "what is not given is kept; checks for height, room, bounds, grid, tilt and horizon",
    "4 TeleportFull": "all of it, with the same checks",
    "4 RotateLook": "sets both, unchecked",
    "4 GetReachablePositions": "a search over free moves; the agent stays",
    "4 GetInteractablePoses": "each can be given to TeleportFull, and shows the object",
    "4 GetShortestPath": "taut, on a mesh without movables, to the first position that sees the object",
    "4 SetObjectPoses": "all that can be moved, as listed and nothing else; copies; new ids",
    "4 PlaceObjectAtPoint": "onto the surface below, if there is room, then it settles",
    "4 TeleportObject": "exactly there, if there is room or it is forced",
    "4 DisableObject": "neither seen nor felt, and still listed",
    "4 EnableObject": "back where it was",
    "4 RemoveFromScene": "gone until the next Reset",
    "4 Pass": "time goes on",
    "4 Done": "time goes on",
    "4 PausePhysicsAutoSim": "nothing falls",
    "4 UnpausePhysicsAutoSim": "things fall",
    "4 AdvancePhysicsStep": "a step by hand, while paused",
    "4 AddThirdPartyCamera": "one more image of each kind an event",
    "4 UpdateThirdPartyCamera": "what is given changes, the rest stays",
    "4 ToggleMapView": "the room from above without its ceiling, and back",
    "4 GetMapViewCameraProperties": "the camera that shows the room from above",
    "4 GetSpawnCoordinatesAboveReceptacle": "points where small things find room",
    "4 RandomizeMaterials": "other finishes; ids and depth stay",
    "4 ResetMaterials": "the finishes of the scene",
    "4 InitialRandomSpawn": "a rearranged scene, the same for the same seed",
    "4 SetObjectFilter": "only these objects in the metadata",
    "4 ResetObjectFilter": "all of them",
    "4 GetScenesInBuild": "the 120 floor plans and the scene for houses",
    "4 ChangeResolution": "the size of all images",
    "4 ChangeQuality": "accepted; there is one quality",
    "4 SetRandomSeed": "what is drawn afterwards repeats",
    "4 CreateHouse": "a ProcTHOR house; what is none is refused with the place and the reason",
}
"""Line -> what it is about, in the contract's order."""


def marks() -> Iterator[tuple[str, str, str]]:
    """(line, file, test) for every mark on a test beside this file, in the order of files and tests."""
    for path in sorted(Path(__file__).parent.glob("test_*.py")):
        for test in ast.parse(path.read_text()).body:
            if not isinstance(test, ast.FunctionDef):
                continue
            for mark in test.decorator_list:
                if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "pytest.mark.contract":
                    yield from ((ast.literal_eval(line), path.name, test.name) for line in mark.args)


def table() -> str:
    """The lines and their tests in Markdown."""
    rows = ["| line | what holds | tests |", "|---|---|---|"]
    marked = list(marks())
    for line, about in LINES.items():
        tests = [f"`{test}`" for of, _, test in marked if of == line]
        more = f" and {len(tests) - NAMED} more" if len(tests) > NAMED else ""
        name = f"`{line.removeprefix('4 ')}`" if line.startswith("4 ") else line
        rows.append(f"| {name} | {about} | {', '.join(tests[:NAMED])}{more} |")
    return "\n".join(rows) + "\n"


def written(page: str) -> str:
    """The page with the table as it is now between its marks. ValueError if it has none."""
    before, mark, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not mark or not end:
        raise ValueError(f"the page has no {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n{table()}{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text()))
