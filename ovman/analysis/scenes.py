"""The success of every arm scene by scene."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from ovman.analysis.difficulty import natural
from ovman.analysis.outcomes import EmbodiedOutcome, StaticOutcome
from ovman.analysis.rates import Interval, Outcome, Rate, by_arm, embodied_rate, static_rate
from ovman.settings import Kind


@dataclass(frozen=True, slots=True)
class SceneRate:
    """One arm on the n episodes of one scene; all else as in ``ovman.analysis.rates.Rate``."""

    kind: Kind
    arm: str
    scene: str
    n: int
    seeds: int
    successes: float
    rate: float
    low: float
    high: float
    interval: Interval
    confidence: float
    least: float | None
    greatest: float | None


def scenes(static: Sequence[StaticOutcome], embodied: Sequence[EmbodiedOutcome], confidence: float) -> list[SceneRate]:
    """Every arm on every scene: arms as they come, static ones first, then scenes by the number in their name."""
    return [
        *_of_kind(Kind.STATIC, static, static_rate, confidence),
        *_of_kind(Kind.EMBODIED, embodied, embodied_rate, confidence),
    ]


def _of_kind(
    kind: Kind, outcomes: Sequence[Outcome], rate_of: Callable[[str, str, Sequence[Outcome], float], Rate], confidence: float
) -> list[SceneRate]:
    rows = []
    for arm, of_arm in by_arm(outcomes).items():
        for scene in sorted({outcome.scene for outcome in of_arm}, key=natural):
            rate = rate_of(arm, scene, [outcome for outcome in of_arm if outcome.scene == scene], confidence)
            rows.append(
                SceneRate(
                    kind=kind,
                    arm=arm,
                    scene=scene,
                    n=rate.n,
                    seeds=rate.seeds,
                    successes=rate.successes,
                    rate=rate.rate,
                    low=rate.low,
                    high=rate.high,
                    interval=rate.interval,
                    confidence=confidence,
                    least=rate.least,
                    greatest=rate.greatest,
                )
            )
    return rows
