"""Lines of the engine's contract and the tests that stand for each; `python -m tests.engine.conformance.lines` prints them."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

LINES = {
    "1.1": "Command line, log",
    "1.2": "Environment; headless",
    "1.3": "The server pipe is opened before anything else",
    "1.4": "Order of the first messages",
    "1.5": "Frames",
    "1.6": "Sequence numbers, fast emit",
    "1.7": "What the Controller asks for from its start to a reset",
    "1.8": "What `step` makes of its arguments",
    "1.9": "Keys of the metadata",
    "1.10": "Images",
    "1.11": "Colours of instances and classes",
    "1.12": "Error codes",
    "1.13": "Death of the engine",
    "1.14": "End with the client",
    "2 world": "Axes, yaw, pitch",
    "2 default agent": "Heights, field of view, depth",
    "2 locobot": "The low agent",
    "2 start position": "On the lattice, at the recorded distances",
    "2 camera": "Projection",
    "2 move test": "A step is free or blocked",
    "2 reachable": "The grid",
    "2 visibility": "What counts as visible",
    "2 objectId": "Ids and names",
    "2 isMoving": "Rest and motion",
    "3 matching": "Matching by names; nothing half done",
    "3 server actions": "Actions that take anything",
    "3 unknown": "InvalidAction",
    "3 missing": "MissingArguments",
    "3 superfluous": "InvalidArgument: too many",
    "3 unconvertible": "InvalidArgument: not convertible",
    "3 exception": "Exceptions inside actions",
    "3 extra keys": "Keys that are always accepted",
    **{
        f"4 {action}": action
        for action in (
            *("Initialize", "Reset", "MoveAhead", "MoveBack", "MoveLeft", "MoveRight", "RotateLeft", "RotateRight"),
            *("LookUp", "LookDown", "Crouch", "Stand", "Teleport", "TeleportFull", "RotateLook", "GetReachablePositions"),
            *("GetInteractablePoses", "GetShortestPath", "SetObjectPoses", "PlaceObjectAtPoint", "TeleportObject"),
            *("DisableObject", "EnableObject", "RemoveFromScene", "Pass", "Done", "PausePhysicsAutoSim"),
            *("UnpausePhysicsAutoSim", "AdvancePhysicsStep", "AddThirdPartyCamera", "UpdateThirdPartyCamera", "ToggleMapView"),
            *("GetMapViewCameraProperties", "GetSpawnCoordinatesAboveReceptacle", "RandomizeMaterials", "ResetMaterials"),
            *("InitialRandomSpawn", "SetObjectFilter", "ResetObjectFilter", "GetScenesInBuild", "ChangeResolution"),
            *("ChangeQuality", "SetRandomSeed", "CreateHouse"),
        )
    },
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
    rows = ["| contract | about | tests |", "|---|---|---|"]
    marked = list(marks())
    for line, about in LINES.items():
        tests = [f"`{test}`" for of, _, test in marked if of == line]
        rows.append(f"| {line} | {about} | {', '.join(tests)} |")
    return "\n".join(rows) + "\n"


if __name__ == "__main__":
    print(table(), end="")
