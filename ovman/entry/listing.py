"""Rows on what there is: splits, agents and episodes."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from ovman.entry import EntryError
from ovman.entry.entrant import list_arms
from ovman.entry.release import Release
from ovman.language import noun, sentence
from ovman.records.episode import Episode
from ovman.settings import Arm, Settings, Source

PROTOCOL = ("homes", "changes", "others", "second_tour", "light", "sensors")
"""Settings of a split that differ from the paper's protocol if they are given."""


def list_splits(release: Release) -> list[dict[str, Any]]:
    """Return one row per split: its name, released episodes, scenes, purpose, and settings that differ from the paper's."""
    rows = []
    for name, split in release.settings.splits.items():
        path = release.directory / "episodes" / f"{name}.jsonl"
        there = Episode.load(path) if path.is_file() else []
        differs = ", ".join(key for key in PROTOCOL if key in split.model_fields_set) or "—"
        purpose = "test" if split.in_main_job else "tuning"
        scenes = len({one.scene for one in there})
        rows.append({"split": name, "episodes": len(there), "scenes": scenes, "for": purpose, "differs in": differs})
    return rows


def list_agents(settings: Settings) -> list[dict[str, Any]]:
    """Return one row per arm that `ovman eval` runs."""
    arms = [settings.arms[name] for name in list_arms(settings)]
    return [
        {
            "agent": arm.name,
            "title": arm.system,
            "memory": arm.memory,
            "role": _role(arm),
        }
        for arm in arms
    ]


def list_episodes(release: Release, split: str, scenes: Collection[str]) -> list[dict[str, Any]]:
    """Return one row per episode of a split, or of some of its scenes. EntryError for a scene that it lacks."""
    episodes = Episode.load(release.episodes(split))
    there = sorted({episode.scene for episode in episodes})
    if absent := [scene for scene in scenes if scene not in there]:
        raise EntryError(f"--scenes: {absent[0]} has no episode of {split}; write some of {', '.join(there)}")
    return [
        {
            "episode": one.id,
            "scene": one.scene,
            "relation": str(one.relation),
            "sentence": sentence(one.relation, noun(one.category)),
        }
        for one in episodes
        if not scenes or one.scene in scenes
    ]


def _role(arm: Arm) -> str:
    if Source.HANDED in (arm.grounding, arm.positions, arm.answer):
        return "diagnostic"
    return "control" if arm.control else "system"
