"""Answer the episodes of a split from the data set alone, without OVMAN and without a simulator.

    ovman dataset --out small --split dev
    python examples/points_from_dataset.py      # writes mine.jsonl
    ovman score mine.jsonl --split dev

The agent reads no word except whether the place is past. It compares views that both tours take from the same pose, so it works
on splits whose second tour repeats the first.
"""

import json

import numpy as np
from datasets import load_dataset

episodes = load_dataset("small", "episodes", split="dev")
tours = load_dataset("small", "tours", split="dev")
rows = {}
for number, tour in enumerate(tours["tour"]):
    rows.setdefault(tour, []).append(number)


def nearest_new_place(before, after):
    """Return (metres, x, z) where `after` sees something most in front of what `before` sees, from one pose."""
    depth, other = (np.asarray(view["depth"]) / 1000 for view in (after, before))
    nearer = np.where(depth > 0, other - depth, 0.0)
    row, column = np.unravel_index(nearer.argmax(), nearer.shape)
    forward = depth[row, column]
    right = (column + 0.5 - after["cx"]) / after["fx"] * forward
    yaw = np.radians(after["yaw_deg"])
    x = after["camera_x"] + right * np.cos(yaw) + forward * np.sin(yaw)
    z = after["camera_z"] - right * np.sin(yaw) + forward * np.cos(yaw)
    return nearer[row, column], x, z


with open("mine.jsonl", "w") as file:
    for episode in episodes:
        first, second = (tours.select(rows[episode[which]]) for which in ("first_tour", "second_tour"))
        past = episode["relation"] in ("former", "removed")
        pairs = zip(second, first, strict=True) if past else zip(first, second, strict=True)
        _, x, z = max(nearest_new_place(before, after) for before, after in pairs)
        file.write(json.dumps({"episode": episode["episode"], "x": float(x), "z": float(z)}) + "\n")
