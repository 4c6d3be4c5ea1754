"""The settings of config.yaml: a frozen pydantic model a section, and `Settings`, which has them all."""

from ovman.models.settings.arms import Arm, Arms, Kind, Need, Reading, Source, Withheld, arms_of, named, of_kind
from ovman.models.settings.comparisons import Comparisons, Pair, PaperRows
from ovman.models.settings.settings import Settings
from ovman.models.settings.splits import MAIN, Split, splits_of
from ovman.models.settings.values import Section

__all__ = [
    "MAIN",
    "Arm",
    "Arms",
    "Comparisons",
    "Kind",
    "Need",
    "Pair",
    "PaperRows",
    "Reading",
    "Section",
    "Settings",
    "Source",
    "Split",
    "Withheld",
    "arms_of",
    "named",
    "of_kind",
    "splits_of",
]
