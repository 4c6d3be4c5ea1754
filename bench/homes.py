"""Draw homes and report what they are like: `python bench/homes.py [COUNT] [ASSETS]`.

Prints how often a home was drawn again and why, the processor time of a home, the categories with two loose instances or more
that look different, and what is in a room per square metre, next to iTHOR's rooms.
"""

from __future__ import annotations

import sys
import time
from collections import Counter, defaultdict
from collections.abc import Mapping

import numpy as np

from ovman.homes.catalogue import LARGE_MM, Asset, looks_different
from ovman.homes.command import list_things
from ovman.homes.generate import Home, draw
from ovman_engine.plan import floorplan
from ovman_engine.world.world import World

KINDS = {"LivingRoom": "living room", "Bedroom": "bedroom", "Kitchen": "kitchen", "Study": "living room"}
"""Kind of room of a home -> kind of iTHOR's floor plans to compare it with"""
LARGE_HOME_M2 = 35.0
WHAT = ("movable", "large", "on tops")

Rates = Mapping[str, list[list[float]]]
"""Kind of room -> for each room movable things, large ones and those on tops, per square metre"""


def measure_ithor() -> Rates:
    """Return what is in iTHOR's rooms. Their area is that within the inferred walls."""
    out = defaultdict(list)
    for number in (n for first in (1, 201, 301) for n in range(first, first + 30)):
        plan = floorplan.load(f"FloorPlan{number}")
        x_0, z_0, x_1, z_1 = World(plan).room.outline
        movable = [o for o in plan.objects if o.dynamic]
        sizes = [sorted(2000 * o.box.half) for o in movable]
        large = sum(longest >= LARGE_MM[0] and second >= LARGE_MM[1] for _, second, longest in sizes)
        on_tops = sum(any(not name.startswith("Floor") for name in o.parents) for o in movable)
        area = (x_1 - x_0) * (z_1 - z_0)
        out[plan.kind.replace("_", " ")].append([len(movable) / area, large / area, on_tops / area])
    return out


def measure_rooms(homes: list[Home], split: str) -> Rates:
    """Return what is in the rooms of homes."""
    out = defaultdict(list)
    for home in homes:
        things = [(room, asset, on_top) for room, asset, on_top in list_things(home.house, split) if asset.movable]
        for room, kind in zip(home.house["rooms"], home.house["metadata"]["roomSpecId"].split("-"), strict=True):
            area = home.report.areas_m2[room["id"]]
            here = [(asset, on_top) for number, asset, on_top in things if room["id"] == f"room|{number}"]
            counts = (len(here), sum(asset.large for asset, _ in here), sum(on_top for _, on_top in here))
            out[kind].append([count / area for count in counts])
    return out


def count_looks(found: list[Asset]) -> int:
    """Return the number of assets that all look different from each other, found greedily."""
    chosen: list[Asset] = []
    for asset in found:
        if all(looks_different(asset.id, other.id) for other in chosen):
            chosen.append(asset)
    return len(chosen)


def report_abundance(homes: list[Home], split: str) -> None:
    """Print in how many categories large homes have loose things that look different."""
    rich = []
    for home in homes:
        by = defaultdict(list)
        for _, asset, _ in list_things(home.house, split):
            if asset.loose:
                by[asset.category].append(asset)
        looks = [count_looks(found) for found in by.values()]
        if sum(home.report.areas_m2.values()) >= LARGE_HOME_M2:
            rich.append((sum(n >= 2 for n in looks), sum(n >= 3 for n in looks)))
    fit = np.mean([two >= 5 and three >= 2 for two, three in rich])
    two, three = np.median(rich, axis=0)
    print(f"{len(rich)} homes of {LARGE_HOME_M2:.0f} m2: {fit:.1%} have 5 categories of 2 looks and 2 of 3 looks")
    print(f"   median: {two:.0f} categories of 2 looks, {three:.0f} of 3")


def main() -> None:
    """Draw the homes, half of one room, and print the report."""
    count, split = int((sys.argv[1:] or ["200"])[0]), (sys.argv[2:] or ["test"])[0]
    homes, times = [], defaultdict(list)
    for seed in range(count):
        rooms = 1 if seed % 2 == 0 else 2 + seed // 2 % 2
        start = time.process_time()
        homes.append(draw(f"0.{seed}", rooms, split))
        times[rooms].append(time.process_time() - start)
    redraws = [faults for home in homes for faults in home.redraws]
    print(f"{count} homes, {len(redraws)} redraws, {len(redraws) / (count + len(redraws)):.1%} of all draws")
    reasons = Counter(" ".join(w.split("|")[0] for w in faults[0].split() if not w[0].isdigit()) for faults in redraws)
    for reason, number in reasons.most_common(8):
        print(f"   {number} {reason}")
    for rooms, spent in sorted(times.items()):
        areas = [sum(home.report.areas_m2.values()) for home in homes if len(home.report.areas_m2) == rooms]
        print(f"{rooms} rooms: median {np.median(spent):.2f} s, 90 % {np.percentile(spent, 90):.2f} s, {np.median(areas):.0f} m2")
    report_abundance(homes, split)
    ithor = measure_ithor()
    print("per square metre, 10th, 50th and 90th percentile of iTHOR's rooms and of these")
    for kind, rows in sorted(measure_rooms(homes, split).items()):
        for k, what in enumerate(WHAT):
            there, here = np.array(ithor[KINDS[kind]])[:, k], np.array(rows)[:, k]
            low, middle, high = np.percentile(there, [10, 50, 90])
            own = " ".join(f"{value:.2f}" for value in np.percentile(here, [10, 50, 90]))
            inside = np.mean((low <= here) & (here <= high))
            print(f"   {kind:10} {what:8} {low:.2f} {middle:.2f} {high:.2f}   {own}   {inside:.0%} of {len(here)} within")


if __name__ == "__main__":
    main()
