"""Collect recorded.npz from clones of allenai/ai2thor-rearrangement (Apache-2.0) and askforalfred/alfred (MIT).

    python bench/unity/collect.py REARRANGEMENT ALFRED

The first holds data/2023/*.pkl.gz, recorded in AI2-THOR 5.0; the second gen/layouts/*-layout.npy, recorded in AI2-THOR 2.1.
"""

from __future__ import annotations

import gzip
import pickle
import sys
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

RECORDED = Path(__file__).with_name("recorded.npz")


class Plain(pickle.Unpickler):
    """Reads pickles of plain data, and refuses those that would call code."""

    def find_class(self, module: str, name: str) -> NoReturn:
        raise pickle.UnpicklingError(f"the file is not plain data: it names {module}.{name}")


def episodes(folder: Path) -> dict[str, list[dict[str, Any]]]:
    """Return the episodes of every scene."""
    found = {}
    for split in ("train", "val", "test"):
        with gzip.open(folder / f"{split}.pkl.gz") as file:
            found |= Plain(file).load()
    return found


def _vectors(records: list[dict[str, float]]) -> np.ndarray:
    return np.array([[r[axis] for axis in "xyz"] for r in records], dtype=np.float32)


def main(rearrangement: str, alfred: str) -> None:
    """Write recorded.npz: positions of agents, reachable grids, and poses of objects at rest in the first episode of a scene."""
    found = episodes(Path(rearrangement) / "data" / "2023")
    scenes = sorted(found)
    rests = [(scene, pose) for scene in scenes for pose in found[scene][0]["starting_poses"]]
    grids = [np.load(Path(alfred) / "gen" / "layouts" / f"{scene}-layout.npy") for scene in scenes]
    np.savez_compressed(
        RECORDED,
        agent_scene=np.repeat(scenes, [len(found[s]) for s in scenes]),
        agent=_vectors([e["agent_position"] for s in scenes for e in found[s]]),
        grid_scene=np.repeat(scenes, [len(grid) for grid in grids]),
        grid=np.concatenate(grids).astype(np.float32),
        rest_scene=np.array([scene for scene, _ in rests]),
        rest_type=np.array([pose["name"].rpartition("_")[0] for _, pose in rests]),
        rest_position=_vectors([pose["position"] for _, pose in rests]),
        rest_rotation=_vectors([pose["rotation"] for _, pose in rests]),
    )


if __name__ == "__main__":
    main(*sys.argv[1:])
