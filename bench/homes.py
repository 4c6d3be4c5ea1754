"""Draw homes and report what they are like: `python bench/homes.py [COUNT] [ASSETS]`.

Prints how often a home was drawn again and why, the processor time of a home, the categories with two loose instances or more
that look different, and the movable things per square metre next to those of iTHOR's rooms.
"""

from __future__ import annotations

import sys
import time
from collections import Counter, defaultdict

import numpy as np

from ovman.homes.catalogue import Asset
from ovman.homes.command import list_things
from ovman.homes.generate import Home, draw
from ovman.homes.looks import looks_different
from ovman_engine.plan import floorplan
from ovman_engine.world.world import World

KINDS = {"LivingRoom": "living room", "Bedroom": "bedroom", "Kitchen": "kitchen", "Study": "living room"}
"""Kind of room of a home -> kind of iTHOR's floor plans to compare it with"""
LARGE_HOME_M2 = 35.0


def count_looks(found: list[Asset]) -> int:
    """Return the size of a largest set of assets that all look different from each other, found greedily."""
    chosen: list[Asset] = []
    for asset in found:
        if all(looks_different(asset.id, other.id) for other in chosen):
            chosen.append(asset)
    return len(chosen)


def measure_ithor() -> dict[str, list[float]]:
    """Return the movable things per square metre of iTHOR's floor plans, by kind. The area is that within the inferred walls."""
    out = defaultdict(list)
    for number in (n for first in (1, 201, 301) for n in range(first, first + 30)):
        plan = floorplan.load(f"FloorPlan{number}")
        x_0, z_0, x_1, z_1 = World(plan).room.outline
        out[plan.kind.replace("_", " ")].append(sum(o.dynamic for o in plan.objects) / ((x_1 - x_0) * (z_1 - z_0)))
    return out


def main() -> None:
    """Draw the homes and print the report."""
    count, split = int((sys.argv[1:] or ["200"])[0]), (sys.argv[2:] or ["test"])[0]
    limits = {kind: np.percentile(found, [10, 90]) for kind, found in measure_ithor().items()}
    homes: list[tuple[int, Home, float]] = []
    for seed in range(count):
        rooms = 1 if seed % 2 == 0 else 2 + seed // 2 % 2
        start = time.process_time()
        home = draw(f"0.{seed}", rooms, split)
        homes.append((rooms, home, time.process_time() - start))
    redraws = [faults for _, home, _ in homes for faults in home.redraws]
    print(f"{count} homes, {len(redraws)} redraws ({len(redraws) / (count + len(redraws)):.1%})")
    words = Counter(" ".join(w.split("|")[0] for w in fault.split() if not w[0].isdigit()) for f in redraws for fault in f[:1])
    print("  ", dict(words.most_common(8)))
    for rooms in (1, 2, 3):
        times = [seconds for n, _, seconds in homes if n == rooms]
        areas = [sum(home.report.areas_m2.values()) for n, home, _ in homes if n == rooms]
        print(f"{rooms} rooms: {np.median(times):.2f} s (90 %: {np.percentile(times, 90):.2f}), {np.median(areas):.0f} m2")
    rich, dense = [], defaultdict(list)
    for _, home, _ in homes:
        things = list(list_things(home.house, split))
        by = defaultdict(list)
        for _, asset, _ in things:
            if asset.loose:
                by[asset.category].append(asset)
        looks = sorted((count_looks(found) for found in by.values()), reverse=True)
        if sum(home.report.areas_m2.values()) >= LARGE_HOME_M2:
            rich.append((sum(n >= 2 for n in looks), sum(n >= 3 for n in looks)))
        for room, kind in zip(home.house["rooms"], home.house["metadata"]["roomSpecId"].split("-"), strict=True):
            number = int(room["id"].split("|")[1])
            dense[kind].append(sum(a.movable for n, a, _ in things if n == number) / home.report.areas_m2[room["id"]])
    fit = np.mean([two >= 5 and three >= 2 for two, three in rich])
    print(f"{len(rich)} homes of {LARGE_HOME_M2:.0f} m2: {fit:.1%} have 5 categories of 2 looks and 2 of 3 looks")
    print(f"   median {np.median(rich, axis=0)}")
    for kind, found in sorted(dense.items()):
        low, high = limits[KINDS[kind]]
        inside = np.mean([low <= value <= high for value in found])
        says = f"{inside:.0%} of {len(found)} rooms within iTHOR's {low:.2f} to {high:.2f}"
        print(f"{kind}: {np.median(found):.2f} movable things per m2; {says}")


if __name__ == "__main__":
    main()
