"""The tables of success rates: the static gate and the embodied evaluation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence

from ovman.analysis.rates import ALL, Interval
from ovman.models.settings import Arm, Kind, Source, of_kind
from ovman.report.cells import MARK, RELATIONS, Record, number, percent, small_capitals, span
from ovman.report.table import (
    CSV_AND_MARKDOWN,
    DATA,
    PAGE,
    Column,
    Row,
    Table,
    Words,
)


def static_table(rates: Sequence[Record], radius_m: float, confidence: float, arms: Sequence[Arm]) -> Table:
    """The static gate. rates: rows of "static_rates.csv"; radius_m: R; confidence: of the intervals.

    One row an arm that has rates: those on their own first, then those with grounding and with positions handed over, each in the
    order of `arms`. Raises ValueError for an arm that there is not.
    """
    expected = any(rate["interval"] == Interval.POISSON_BINOMIAL for rate in rates)
    caption = (
        f"Static gate: the predicted point must fall within {radius_m} m of the answer; rates over n episodes. "
        f"{_wilson(confidence)}"
    )
    if expected:
        caption += (
            f" {MARK} The expectation of a stochastic pick, not a count of successes: its range is the central one that holds "
            f"the rate of one realised pass over these very episodes with a probability of at least {percent(confidence)}"
            " (Poisson-binomial)."
        )
    if any(int(rate["seeds"]) > 1 for rate in rates):
        caption += (
            " A system that answers otherwise each time it runs has several runs: its rates are means over them, and its ranges "
            "as wide as for one: runs add no episodes."
        )
    return Table(
        name="static",
        caption=caption,
        columns=(
            Column("system", "system"),
            Column("memory", "memory"),
            Column("grounding", "grounding", formats=CSV_AND_MARKDOWN),
            Column("positions", "positions", formats=CSV_AND_MARKDOWN),
            *_relation_columns(),
            *_rate_columns(ALL, small_capitals(ALL)),
            _range_column(confidence),
            Column("n", "n", numeric=True),
            Column("runs", "runs", numeric=True),
            Column("interval", "interval", formats=DATA),
        ),
        rows=tuple(
            Row(
                {
                    "system": arm.system,
                    "memory": arm.memory,
                    "grounding": arm.grounding.value,
                    "positions": arm.positions.value,
                    **_rate_cells(of_arm),
                    "n": of_arm[ALL]["n"],
                    "runs": of_arm[ALL]["seeds"],
                    "interval": of_arm[ALL]["interval"],
                },
                section=_section(arm),
            )
            for arm, of_arm in _by_arm(rates, sorted(of_kind(arms, Kind.STATIC), key=_handed_over), Kind.STATIC)
        ),
        wide=True,
    )


def embodied_table(rates: Sequence[Record], confidence: float, arms: Sequence[Arm]) -> Table:
    """The embodied evaluation. rates: rows of "embodied_rates.csv"; confidence: of the intervals. Else as ``static_table``."""
    return Table(
        name="embodied",
        caption=(
            "Embodied evaluation: success rate (SR) at the stop and SPL over n episodes, means over the seeds. "
            f"{_wilson(confidence)} They are as wide as for one pass over the n episodes: seeds add no episodes. The shortest "
            "path of SPL is that of the episode, whatever body an agent has."
        ),
        columns=(
            Column("agent", "agent"),
            *_relation_columns(),
            *_rate_columns("sr", "SR"),
            _range_column(confidence),
            Column("spl", "SPL", numeric=True),
            Column("n", "n", numeric=True),
            Column("seeds", "seeds", numeric=True),
        ),
        rows=tuple(
            Row(
                {
                    "agent": arm.system,
                    **_rate_cells(of_arm, whole="sr"),
                    "spl": number(of_arm[ALL]["spl"]),
                    "n": of_arm[ALL]["n"],
                    "seeds": of_arm[ALL]["seeds"],
                }
            )
            for arm, of_arm in _by_arm(rates, of_kind(arms, Kind.EMBODIED), Kind.EMBODIED)
        ),
        wide=True,
    )


def _by_arm(rates: Iterable[Record], arms: Sequence[Arm], kind: Kind) -> list[tuple[Arm, dict[str, Record]]]:
    by_arm: dict[str, dict[str, Record]] = {}
    for rate in rates:
        by_arm.setdefault(rate["arm"], {})[rate["relation"]] = rate
    strangers = sorted(by_arm.keys() - {arm.name for arm in arms})
    if strangers:
        raise ValueError(f"{strangers[0]!r} is no {kind} arm; there are {', '.join(arm.name for arm in arms)}")
    return [(arm, by_arm[arm.name]) for arm in arms if arm.name in by_arm]


def _relation_columns() -> list[Column]:
    return [column for relation in RELATIONS for column in _rate_columns(relation, small_capitals(relation))]


def _rate_columns(key: str, title: Words) -> tuple[Column, ...]:
    return (
        Column(key, title, numeric=True),
        Column(f"{key}_low", f"{key} low", numeric=True, formats=DATA),
        Column(f"{key}_high", f"{key} high", numeric=True, formats=DATA),
        # Of single seeds or runs.
        Column(f"{key}_min", f"{key} least", numeric=True, formats=DATA),
        Column(f"{key}_max", f"{key} greatest", numeric=True, formats=DATA),
    )


def _range_column(confidence: float) -> Column:
    return Column("range", percent(confidence), formats=PAGE)


def _rate_cells(of_arm: Mapping[str, Record], whole: str = ALL) -> dict[str, str]:
    cells = {}
    for relation in (*RELATIONS, ALL):
        if relation in of_arm:
            rate, key = of_arm[relation], whole if relation == ALL else relation
            cells |= {
                key: number(rate["rate"]),
                f"{key}_low": number(rate["low"]),
                f"{key}_high": number(rate["high"]),
                f"{key}_min": number(rate["least"]) if rate["least"] else "",
                f"{key}_max": number(rate["greatest"]) if rate["greatest"] else "",
            }
    mark = MARK if of_arm[ALL]["interval"] == Interval.POISSON_BINOMIAL else ""
    return cells | {"range": span(of_arm[ALL]["low"], of_arm[ALL]["high"]) + mark}


def _handed_over(arm: Arm) -> int:
    """How much an arm is handed over."""
    return (arm.grounding is Source.HANDED) + 2 * (arm.positions is Source.HANDED)


def _section(arm: Arm) -> str | None:
    if arm.positions is Source.HANDED:
        return "positions handed over (diagnostic)"
    return "grounding handed over (diagnostic)" if arm.grounding is Source.HANDED else None


def _wilson(confidence: float) -> str:
    return f"Ranges are Wilson {percent(confidence)} intervals."
