"""The settings of config.yaml: a frozen pydantic model a section, and `Settings`, which has them all."""

from ovman.section import Section
from ovman.settings.arms import Arm, Arms, Kind, Need, Reading, Source, Withheld, arms_of, of_kind
from ovman.settings.comparisons import Comparisons, Pair, PaperRows
from ovman.settings.settings import Settings
from ovman.settings.splits import MAIN, Lighting, SecondTour, Split

__all__ = [
    "MAIN",
    "Arm",
    "Arms",
    "Comparisons",
    "Kind",
    "Lighting",
    "Need",
    "Pair",
    "PaperRows",
    "Reading",
    "SecondTour",
    "Section",
    "Settings",
    "Source",
    "Split",
    "Withheld",
    "arms_of",
    "of_kind",
]
