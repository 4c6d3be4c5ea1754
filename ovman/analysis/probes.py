"""The stage "probes": the two-visit agent asked again, under other association gates and with one past relation for the other.

The agent is the arm of comparisons.memory.

Source: Fig. diag (b), and "the only confusions (REMOVED read as FORMER) resolve to the same answer location".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from ovman.analysis import frames
from ovman.analysis.statistics import wilson_interval
from ovman.evaluation.observations import VISITS, Stores
from ovman.evaluation.predictions import predict
from ovman.records.episode import Episode
from ovman.records.prediction import Answer, Predicted
from ovman.records.task import Relation
from ovman.settings import Arm
from ovman.workflow.parameter import StageSettings

GATE_SWEEP, READ_AS = "gate_sweep.csv", "read_as.csv"
GATE = "association.gate_m"
SWAPPED: Mapping[Relation, Relation] = {Relation.REMOVED: Relation.FORMER, Relation.FORMER: Relation.REMOVED}
"""What each past relation is read as."""
Asked = Callable[[Episode, StageSettings], Predicted]
"""What an arm answers to an episode under some settings."""


@dataclass(frozen=True, slots=True)
class GateRate:
    """Static success under one association gate, metres. in_force: whether it is the gate of config.yaml; delta_min_m: Delta_min
    there, which the gate must not reach. low, high: Wilson's interval at ``confidence``."""

    gate_m: float
    in_force: bool
    delta_min_m: float
    n: int
    successes: int
    success: float
    low: float
    high: float
    confidence: float


@dataclass(frozen=True, slots=True)
class ReadAs:
    """The n episodes of a past relation, each asked as it is meant and as if the other had been said.

    answered: how many have an answer as they are meant; same: how many of these have the same answer when read as the other;
    only_read_as: how many have one only then, by the fallback. successes, successes_read_as: on the static gate.
    """

    relation: Relation
    read_as: Relation
    n: int
    answered: int
    same: int
    only_read_as: int
    successes: int
    successes_read_as: int


def gate_sweep(episodes: Sequence[Episode], asked: Asked, constants: StageSettings) -> list[GateRate]:
    """A row for each gate of section gate_sweep and for the one in force, rising."""
    in_force, confidence = constants.association.gate_m, constants.evaluation.confidence
    rows = []
    for gate_m in sorted({*constants.gate_sweep.gates_m, in_force}):
        settings = constants.with_values({GATE: gate_m})
        n, won = len(episodes), sum(_succeeds(asked(one, settings), one, constants) for one in episodes)
        low, high = wilson_interval(won, n, confidence)
        delta_min_m = constants.candidates.delta_min_m
        rows.append(GateRate(gate_m, gate_m == in_force, delta_min_m, n, won, won / n, low, high, confidence))
    return rows


def read_as(episodes: Sequence[Episode], asked: Asked, constants: StageSettings) -> list[ReadAs]:
    """A row for each past relation that there are episodes of."""
    rows = []
    for relation, other in SWAPPED.items():
        group = [one for one in episodes if one.relation is relation]
        meant = [asked(one, constants) for one in group]
        swapped = [asked(one.model_copy(update={"relation": other}), constants) for one in group]
        won, won_swapped = (
            sum(_succeeds(answer, one, constants) for answer, one in zip(answers, group, strict=True))
            for answers in (meant, swapped)
        )
        answered = [isinstance(answer, Answer) for answer in meant]
        rows.append(
            ReadAs(
                relation=relation,
                read_as=other,
                n=len(group),
                answered=sum(answered),
                same=sum(a == b for a, b, there in zip(meant, swapped, answered, strict=True) if there),
                only_read_as=sum(isinstance(b, Answer) and not there for b, there in zip(swapped, answered, strict=True)),
                successes=won,
                successes_read_as=won_swapped,
            )
        )
    return [row for row in rows if row.n]


def run(arm: Arm, episodes_file: Path, maps: Sequence[Path], nouns: Path, constants: StageSettings, output_dir: Path) -> None:
    """Write both files into output_dir. arm: needs maps at most; maps: one file a scene, named after it.

    constants: of the stage, and what the arm's entry names.
    """
    episodes = Episode.load(episodes_file)
    stores = Stores(arm, constants, VISITS, {"nouns": nouns, "maps": maps[0].parent if maps else nouns})

    def asked(episode: Episode, settings: StageSettings) -> Predicted:
        store = stores.of(episode.scene, episode.protocol.camera.field_of_view_deg)
        return predict(arm, episode, settings, store)[0]

    gates = gate_sweep(episodes, asked, constants) if episodes else []
    frames.write(output_dir / GATE_SWEEP, GateRate, gates)
    frames.write(output_dir / READ_AS, ReadAs, read_as(episodes, asked, constants))
    print(", ".join(f"gate {row.gate_m} m: {row.success:.3f}" for row in gates), flush=True)


def _succeeds(answer: Predicted, episode: Episode, constants: StageSettings) -> bool:
    return isinstance(answer, Answer) and math.dist((answer.x, answer.z), episode.answer) <= constants.success.radius_m
