"""All settings of config.yaml as one typed tree."""

from __future__ import annotations

from typing import Any

from pydantic import model_validator

from ovman.models.settings.arms import Arms
from ovman.models.settings.baselines import Cow, Dualmap, Locobot, Released
from ovman.models.settings.benchmark import (
    Admissibility,
    Association,
    Benchmark,
    Camera,
    Candidates,
    Evaluation,
    Grounding,
    Maps,
    Measurement,
    Mover,
    Primitives,
    SingleVisit,
    Success,
    Tour,
)
from ovman.models.settings.networks import Perception, Training
from ovman.models.settings.values import Section


class Settings(Section):
    """All settings of config.yaml, by section."""

    benchmark: Benchmark
    camera: Camera
    tour: Tour
    primitives: Primitives
    mover: Mover
    candidates: Candidates
    measurement: Measurement
    admissibility: Admissibility
    success: Success
    perception: Perception
    maps: Maps
    grounding: Grounding
    association: Association
    single_visit: SingleVisit
    evaluation: Evaluation
    dualmap: Dualmap
    released: Released
    training: Training
    locobot: Locobot
    cow: Cow
    arms: Arms

    @model_validator(mode="before")
    @classmethod
    def _without_clones(cls, tree: Any) -> Any:
        """Arms of released systems of which no clone is named are left out."""

        def named(entry: Any) -> bool:
            here = tree.get("released")
            for key in (entry.get("released") if isinstance(entry, dict) else None, "root"):
                here = here.get(key) if isinstance(here, dict) and isinstance(key, str) else None
            return bool(here != "")

        if not isinstance(tree, dict) or not isinstance(tree.get("arms"), dict):
            return tree
        return {**tree, "arms": {name: entry for name, entry in tree["arms"].items() if named(entry)}}
