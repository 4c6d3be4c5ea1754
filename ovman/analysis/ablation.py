"""The stage "ablation": what each setting of a split costs each static arm, alone and together with the others."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.outcomes import outcomes_of
from ovman.analysis.rates import Rate, static_rates
from ovman.settings import Settings


@dataclass(frozen=True, slots=True)
class AblationRate(Rate):
    """The success of an arm on a variant of a split's episodes. variant: a name of `ovman.records.episode.VARIANTS`."""

    variant: str = ""


def run(variants: Mapping[str, tuple[Path, Sequence[Path]]], constants: Settings, output: Path) -> None:
    """Write the rates of the arms on every variant. variants: by name, its episodes and the files of the arms' predictions.

    constants: success.radius_m, single_visit.samples, benchmark.seed, evaluation.confidence. Raises ValueError in one line unless
    each arm answers every episode exactly once in each of its runs.
    """
    rows = []
    for name, (episodes_file, prediction_files) in variants.items():
        for rate in static_rates(outcomes_of(episodes_file, prediction_files, constants), constants.evaluation.confidence):
            rows.append(AblationRate(**{field: getattr(rate, field) for field in Rate.__slots__}, variant=name))
    frames.write(output, AblationRate, rows)
