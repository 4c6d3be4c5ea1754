"""All settings of config.yaml as one typed tree."""

from __future__ import annotations

from pydantic import Field

from ovman.models.settings.arms import Arms
from ovman.models.settings.baselines import Cow, Dualmap, Dynamem, Locobot, React
from ovman.models.settings.benchmark import (
    Admissibility,
    Appearance,
    Association,
    Benchmark,
    Camera,
    Candidates,
    Controls,
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
from ovman.models.settings.comparisons import Comparisons, PaperRows
from ovman.models.settings.explore import Explore
from ovman.models.settings.joint import Joint
from ovman.models.settings.networks import Perception, Training
from ovman.models.settings.remote import Remote
from ovman.models.settings.sensitivity import GateSweep, Sensitivity
from ovman.models.settings.sensors import Levels
from ovman.models.settings.splits import Splits
from ovman.models.settings.values import Section


class Settings(Section):
    """All settings of config.yaml, by section. Each plug-in adds a section (`ovman.workflow.plugins`)."""

    benchmark: Benchmark
    camera: Camera
    tour: Tour
    primitives: Primitives
    mover: Mover
    candidates: Candidates
    splits: Splits
    sensors: Levels
    measurement: Measurement
    admissibility: Admissibility
    success: Success
    perception: Perception
    maps: Maps
    grounding: Grounding
    association: Association
    appearance: Appearance
    single_visit: SingleVisit
    evaluation: Evaluation
    sensitivity: Sensitivity
    gate_sweep: GateSweep
    explore: Explore
    dualmap: Dualmap
    joint: Joint
    dynamem: Dynamem
    react: React
    training: Training
    locobot: Locobot
    cow: Cow
    controls: Controls
    remote: Remote
    plugins: dict[str, str] = Field(description="modules of plug-ins by the names of their sections")
    arms: Arms
    comparisons: Comparisons
    paper: PaperRows
