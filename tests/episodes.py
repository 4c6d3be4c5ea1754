"""Records of episodes for tests: released ones with other content."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from ovman.models.episode import Episode

ROOT = Path(__file__).parents[1]
RELEASED = ROOT / "data" / "ovman-embedded-v1"
TARGET, OTHER = "a", "b"


@cache
def released() -> tuple[Episode, ...]:
    """The released episodes."""
    return tuple(Episode.load(RELEASED / "episodes" / "main.jsonl"))


def episode_record(
    relation: str,
    number: int = 0,
    *,
    answer: tuple[float, float] = (1.0, 0.0),
    world: Sequence[Mapping[str, Any]] | None = None,
    visits: Mapping[str, str] | None = None,
    scene: str = "FloorPlan1",
    category: str = "Chair",
) -> dict[str, Any]:
    """A whole record: a released episode of the relation with another id, answer and worlds. TARGET is the queried instance."""
    record = next(one for one in released() if one.relation == relation).to_json()
    point = {"x": answer[0], "z": answer[1]}
    here = [{"id": TARGET, "category": category, **point}] if world is None else list(world)
    distractor = OTHER if record["distractor"] is not None else None
    return record | {
        "id": f"{scene}/{relation}/{number:04d}",
        "scene": scene,
        "category": category,
        "instances_in_category": 2,
        "answer": point,
        "target": TARGET,
        "distractor": distractor,
        "changes": [{**change, "instance": distractor or TARGET} for change in record["changes"][:1]],
        "visits": visits or record["visits"],
        "world_1": here,
        "world_2": here,
    }
