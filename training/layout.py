"""Make ovman/agents/layout.json, where things stand in homes with train assets: `python -m training.layout [HOMES]`.

300 homes of one and two rooms took seven minutes on a busy core.
"""

from __future__ import annotations

import json
import sys
from collections import defaultdict

import numpy as np

from ovman.agents.layout import COUNTS, EDGES, STEP_M, describe_places, lay_lattice
from ovman.homes.catalogue import assets, categories
from ovman.homes.generate import draw
from ovman_engine.plan.house_json import read
from ovman_engine.plan.houseplan import plan_of
from ovman_engine.world.world import World

HOMES = 300
LEAST = 20
"""Categories with fewer things are left out: the answer is then where any thing stands."""


def main() -> None:
    """Count, and write the counts."""
    homes = int(sys.argv[1]) if len(sys.argv) > 1 else HOMES
    movable = {asset.id: asset.category for category in categories() for asset in assets(category, "train") if asset.movable}
    found: dict[str, list[np.ndarray]] = defaultdict(list)
    for k in range(homes):
        house = draw(f"9.{k}", 1 + k % 2, "train").house
        grid = np.array(World(plan_of(read(house))).reachable(STEP_M))[:, [0, 2]]
        found["background"].append(describe_places(grid, lay_lattice(grid)))
        for thing in house["objects"]:
            if thing["assetId"] in movable:
                place = np.array([[thing["position"]["x"], thing["position"]["z"]]])
                found[movable[thing["assetId"]]].append(describe_places(grid, place))
        print(f"{k + 1}/{homes}", flush=True)
    background = _count(found.pop("background"))
    counts = {name: _count(rows) for name, rows in sorted(found.items()) if len(rows) >= LEAST}
    text = json.dumps({"homes": homes, "background": background, "categories": counts}, separators=(",", ":"))
    COUNTS.write_text(text + "\n", encoding="utf-8")


def _count(rows: list[np.ndarray]) -> dict[str, list[int]]:
    binned = np.concatenate(rows)
    return {
        name: np.bincount(binned[:, column], minlength=len(edges) + 1).tolist()
        for column, (name, edges) in enumerate(EDGES.items())
    }


if __name__ == "__main__":
    main()
