"""Lines of the engine's contract and the tests of each: the table in docs/engine.md of this package.

`python tests/conformance/lines.py` writes it there.
"""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

PAGE = Path(__file__).parents[2] / "docs" / "engine.md"
BEGIN, END = "<!-- contract -->", "<!-- end of contract -->"
NAMED = 3
"""How many tests of a line the table names."""
LINES = {
    "1.1": "starts as the client starts a Unity build, from a command with arguments and quoted blanks",
    "1.2": "obeys the environment variables of the client; headless means no images",
    "1.3": "starts where the client would not: a missing DISPLAY, visible GPUs, an engine that cannot start",
    "1.4": "sends the first message unasked, then one answer to every action",
    "1.5": "frames of type, length and body; metadata first, images by agent, then by camera",
    "1.6": "returns sequence numbers; sends unchanged events as patches",
    "1.7": "scenes, resets, sizes and initialisation in the order in which the client does them",
    "1.8": "a rotation may be a number; images can be asked for or left out action by action",
    "1.9": "all keys of the metadata, 42 of every object",
    "1.10": "RGB, metric planar depth, instance ids, classes and normals, bottom row first",
    "1.11": "a colour for every instance and class, with ids images alone",
    "1.12": "four error codes raise ValueError in the client; other failures are falsy events",
    "1.13": "the client notices a killed engine",
    "1.14": "ends when its client stops, dies or closes a pipe; two engines run side by side",
    "2 world": "left-handed metres and degrees, yaw clockwise from +z",
    "2 default agent": "capsule, eye height, field of view and planes of the default agent",
    "2 locobot": "capsule, eye height and noise of the LoCoBot",
    "2 start position": "agents start where AI2-THOR's do",
    "2 camera": "the picture of a camera at a pose, the right way up and round",
    "2 move test": "a move is free exactly if the capsule gets through",
    "2 reachable": "lattice positions that free moves lead to",
    "2 visibility": "near enough, in the image and not hidden; schemes Collider and Distance",
    "2 objectId": "ids from type and start position; names that stay",
    "2 isMoving": "objects at rest, and scenes of them",
    "3 matching": "arguments are matched by name; a refused action changes nothing",
    "3 server actions": "actions of the old style accept any argument",
    "3 unknown": "InvalidAction",
    "3 missing": "MissingArguments",
    "3 superfluous": "InvalidArgument, with the ways to call the action",
    "3 unconvertible": "InvalidArgument, with the expected type",
    "3 exception": "a failed event with the exception's name",
    "3 extra keys": "keys that every action accepts",
    "4 Initialize": "settings, images, planes, agent mode; out-of-range values are refused by name",
    "4 Reset": "restores the same world",
    "4 MoveAhead": "a step along the heading, or the name of the obstacle",
    "4 MoveBack": "backwards",
    "4 MoveLeft": "sideways; not the LoCoBot",
    "4 MoveRight": "sideways; not the LoCoBot",
    "4 RotateLeft": "by any angle but 0",
    "4 RotateRight": "by any angle but 0",
    "4 LookUp": "up to the limit",
    "4 LookDown": "down to the limit",
    "4 Crouch": "lowers the camera; fails when it is down",
    "4 Stand": "raises the camera; fails when it is up",
    "4 Teleport": "keeps what is not given; checks height, collisions, bounds, grid, tilt and horizon",
    "4 TeleportFull": "sets the whole pose, with the same checks",
    "4 RotateLook": "sets yaw and horizon, unchecked",
    "4 GetReachablePositions": "a search over free moves; the agent stays",
    "4 GetInteractablePoses": "TeleportFull accepts each pose, and the object is visible from it",
    "4 GetShortestPath": "taut, on a mesh without movable objects, to the first position from which the object is visible",
    "4 SetObjectPoses": "all movable objects as listed and no others; copies; new ids",
    "4 PlaceObjectAtPoint": "puts the object on the surface below, if it is free; the object then settles",
    "4 TeleportObject": "puts the object exactly there, if the place is free or the action is forced",
    "4 DisableObject": "the object is neither visible nor solid, and still listed",
    "4 EnableObject": "the object is back where it was",
    "4 RemoveFromScene": "the object is gone until the next Reset",
    "4 Pass": "time passes",
    "4 Done": "time passes",
    "4 PausePhysicsAutoSim": "objects stay where they are",
    "4 UnpausePhysicsAutoSim": "objects fall",
    "4 AdvancePhysicsStep": "one step of physics, while paused",
    "4 AddThirdPartyCamera": "one more image of each kind in every event",
    "4 UpdateThirdPartyCamera": "changes what is given, keeps the rest",
    "4 ToggleMapView": "the room from above without its ceiling, and back",
    "4 GetMapViewCameraProperties": "the camera that shows the room from above",
    "4 GetSpawnCoordinatesAboveReceptacle": "points at which small objects fit",
    "4 RandomizeMaterials": "other finishes; ids and depth stay the same",
    "4 ResetMaterials": "the finishes of the scene",
    "4 RandomizeLighting": "lights of other strength and colour within the ranges; ids and depth stay the same",
    "4 ResetLighting": "the lights of the scene",
    "4 InitialRandomSpawn": "a random arrangement, the same for the same seed",
    "4 SetObjectFilter": "restricts the metadata to these objects",
    "4 ResetObjectFilter": "lists all objects",
    "4 GetScenesInBuild": "the 120 floor plans and the scene for houses",
    "4 ChangeResolution": "the size of all images",
    "4 ChangeQuality": "accepted; there is one quality",
    "4 SetRandomSeed": "repeats all later random draws",
    "4 CreateHouse": "a ProcTHOR house; a malformed one is refused with the place and the reason",
}
"""Line -> what holds, in the order of the contract."""


def marks() -> Iterator[tuple[str, str, str]]:
    """Yields (line, file, test) for every mark on a test in this folder, in the order of files and tests."""
    for path in sorted(Path(__file__).parent.glob("test_*.py")):
        for test in ast.parse(path.read_text()).body:
            if not isinstance(test, ast.FunctionDef):
                continue
            for mark in test.decorator_list:
                if isinstance(mark, ast.Call) and ast.unparse(mark.func) == "pytest.mark.contract":
                    yield from ((ast.literal_eval(line), path.name, test.name) for line in mark.args)


def table() -> str:
    """The lines and their tests as a Markdown table."""
    rows = ["| line | what holds | tests |", "|---|---|---|"]
    marked = list(marks())
    for line, about in LINES.items():
        tests = [f"`{test}`" for of, _, test in marked if of == line]
        more = f" and {len(tests) - NAMED} more" if len(tests) > NAMED else ""
        name = f"`{line.removeprefix('4 ')}`" if line.startswith("4 ") else line
        rows.append(f"| {name} | {about} | {', '.join(tests[:NAMED])}{more} |")
    return "\n".join(rows) + "\n"


def written(page: str) -> str:
    """`page` with the current table between its marks. Raises ValueError if the page has no marks."""
    before, mark, rest = page.partition(BEGIN)
    _, end, after = rest.partition(END)
    if not mark or not end:
        raise ValueError(f"the page has no {BEGIN} ... {END}")
    return f"{before}{BEGIN}\n{table()}{END}{after}"


if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text()))
