"""Tables of perception, language and maps: what is detected, understood and mapped, and how answers depend on thresholds."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from ovman.analysis.appearance import APART
from ovman.analysis.language import What
from ovman.analysis.perception import CATEGORIES, CATEGORY, SCENE, SIZE, PerceptionScore
from ovman.perception.labels import LEAST_IOU
from ovman.report.tables import columns as cols
from ovman.report.tables.table import ALL, CSV_AND_MARKDOWN, DATA, Column, Group, TableSpec, Value
from ovman.settings import Settings
from ovman.settings.comparisons import THRESHOLDS

TABLES: dict[str, TableSpec] = {}

# --- perception -----------------------------------------------------------------------------------

RATES = ("recall", "precision", "precision_once", "top1", "top5", "synonym_top1", "synonym_top5")
LEAST = {"recall": 0.75, "precision": 0.75, "precision_once": 0.75, "top1": 0.60, "top5": 0.88}
SYNONYMS_BELOW = 0.10
"""Synonyms may be worse than the own nouns of the same categories by this much."""


class Bar(NamedTuple):
    """The least that a rate of all scenes should reach, and what it reaches."""

    rate: str
    least: float
    reached: float

    @property
    def verdict(self) -> str:
        """Say whether the rate reaches the bar."""
        return "met" if self.reached >= self.least else "not met"


def bars(scores: Sequence[PerceptionScore]) -> dict[str, Bar]:
    """Return the bars by the name of their rate. A rate without masks is NaN, which meets no bar."""
    whole = next(score for score in scores if score.group == ALL)

    def value(name: str) -> float:
        found: float | None = getattr(whole, name)
        return math.nan if found is None else found

    lowest = {**LEAST, **{f"synonym_{top}": value(f"own_{top}") - SYNONYMS_BELOW for top in ("top1", "top5")}}
    return {rate: Bar(rate, lowest[rate], value(rate)) for rate in RATES}


def by_category(scores: Iterable[PerceptionScore]) -> list[PerceptionScore]:
    """Return the rows of single categories, those with the most true masks first."""
    return sorted((one for one in scores if one.group == CATEGORY), key=lambda one: (-(one.true or 0), one.value))


def perception_scores(rows: pd.DataFrame) -> list[PerceptionScore]:
    """Return the rows of a file of perception as scores."""
    records: list[Any] = rows.astype(object).where(rows.notna(), None).to_dict("records")
    return [PerceptionScore(**record) for record in records]


def _perception_rows(rows: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """List all scenes with the bars, then the scores by size and by scene."""
    checked = bars(perception_scores(rows))
    titles = {ALL: "all scenes", CATEGORIES: "all scenes", SIZE: "by size of the mask", SCENE: "by scene"}
    shown = rows.astype(object).assign(of=rows["group"].map(titles))
    shown["which"] = shown["group"].map({ALL: "all", CATEGORIES: "mean over categories"}).fillna(shown["value"])
    whole = shown[shown["group"] == ALL]
    more = [
        {"which": "chance", "top1": whole["chance_top1"].iloc[0], "top5": whole["chance_top5"].iloc[0]},
        {"which": "bar", **{rate: f"≥ {cols.three(bar.least)}" for rate, bar in checked.items()}},
        {"which": "verdict", **{rate: bar.verdict for rate, bar in checked.items()}},
    ]
    parts = [whole, shown[shown["group"] == CATEGORIES], pd.DataFrame(more, dtype=object).assign(of=titles[ALL])]
    return pd.concat([*parts, *(shown[shown["group"] == group] for group in (SIZE, SCENE))], ignore_index=True)


TABLES["perception"] = TableSpec(
    caption=(
        "Distinct tours, single views. Recall: true masks from {s.perception.detector.min_mask_px} px (no walls, ceilings, "
        f"floors) met at an IoU of {LEAST_IOU}; precision: detected masks (confidence {{s.perception.detector.confidence}}) "
        "that meet one. Doubled: met by a surer mask before. Top-1, top-5: the right category among those of the scene, by its "
        f"noun or the mean over synonyms, which may be {SYNONYMS_BELOW:.2f} below."
    ),
    rows=_perception_rows,
    section=cols.get("of"),
    columns=(
        cols.words("of", formats=CSV_AND_MARKDOWN),
        cols.words("which", "masks"),
        cols.numbers("true"),
        *cols.rates("recall"),
        cols.numbers("found", "detected"),
        *cols.rates("precision"),
        cols.numbers("doubled"),
        *cols.rates(precision_once="precision less doubled"),
        cols.numbers("crops"),
        *cols.rates(top1="top-1", top5="top-5", synonym_top1="synonyms top-1", synonym_top5="synonyms top-5"),
    ),
)

ESTIMATES = {"median": "component-wise median", "ray": "single ray at median depth"}


def _backprojection_rows(masks: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """List the errors of both estimates, of every mask and of every object by its worst mask."""
    parts = []
    for kind, of_kind in masks.groupby("mask", sort=False):
        for key, name in ESTIMATES.items():
            errors = of_kind.rename(columns={f"{key}_box_m": "box", f"{key}_centre_m": "centre"})
            worst = errors.groupby(["scene", "object"], sort=False)[["box", "centre"]].max()
            parts += [errors[["box", "centre"]].assign(mask=kind, estimate=name, unit="masks")]
            parts += [worst.assign(mask=kind, estimate=name, unit="objects")]
    return pd.concat(parts, ignore_index=True) if parts else masks.assign(estimate="", unit="")


def _quantile(name: str, share: float) -> Value:
    return lambda group: np.quantile(group.values(name), share)


TABLES["backprojection"] = TableSpec(
    caption=(
        "Self-check of the back-projection on the untouched tours: distance in metres from the estimate to the object's "
        "axis-aligned box (0 inside) and, on the floor plane, to the box's centre, which no visible surface need be near. True "
        "masks of at least {s.perception.detector.min_mask_px} px; detected ones that meet a true instance at an IoU of "
        f"{LEAST_IOU}. Objects count by their worst mask."
    ),
    by=("mask", "estimate", "unit"),
    rows=_backprojection_rows,
    columns=(
        *cols.labels(mask="masks", estimate="estimate", unit="of"),
        cols.numbers("n", value=cols.count_rows),
        *(
            cols.numbers(f"{error}_{key}", f"{error}, {title}", "{:.4f}".format, _quantile(error, share))
            for error in ("box", "centre")
            for key, title, share in (("median", "median", 0.5), ("p95", "95th percentile", 0.95), ("max", "greatest", 1.0))
        ),
    ),
)

# --- language -------------------------------------------------------------------------------------

UNDERSTOOD, SUCCESS, READ_AS = "held-out sentences understood", "success of two visits (static gate)", "read as"
LANGUAGE_ROWS = {
    What.OBJECT: ("object", UNDERSTOOD),
    What.RELATION: ("relation", UNDERSTOOD),
    What.BOTH: ("object and relation", UNDERSTOOD),
    What.SUPPLIED: ("noun and relation supplied", SUCCESS),
    What.RELATION_INFERRED: ("noun supplied, relation inferred", SUCCESS),
    What.NOUN_INFERRED: ("noun inferred, relation supplied", SUCCESS),
    What.INFERRED: ("noun and relation inferred", SUCCESS),
}


def _language_rows(rates: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """List accuracies and success, then how often each relation was read as what; what never happened counts 0."""
    is_count = rates["what"] == What.READ_AS
    measured, counted = rates[~is_count], rates[is_count]
    titles = measured["what"].map(LANGUAGE_ROWS).str
    parts = [measured.assign(title=titles[0], group=titles[1], cell=measured["rate"].map(cols.three))]
    whole = rates.drop_duplicates("relation").set_index("relation")
    for name in (*cols.RELATIONS, *sorted({*counted["read_as"]} - {*cols.RELATIONS})):
        if name not in {*counted["read_as"]}:
            continue
        of_name = counted[counted["read_as"] == name].set_index("relation")["count"].reindex(whole.index, fill_value=0)
        title_of = f"read as {name.upper()}" if name in cols.RELATIONS else f"not parsed: {name.replace('_', ' ')}"
        row = pd.DataFrame({"relation": whole.index, "cell": of_name.astype(str).tolist(), "n": whole["n"].tolist()})
        parts.append(row.assign(title=title_of, group=READ_AS, what=f"{What.READ_AS} {name}"))
    return pd.concat(parts, ignore_index=True)


TABLES["language"] = TableSpec(
    caption=lambda rates, settings: (
        "Held-out sentences, one an episode. A sentence that is not parsed has neither object nor relation right and is a "
        f"failure. The forms were {'; '.join(sorted({*rates['origin']}))}. Ranges are Wilson {{confidence}} intervals; gained "
        "and lost are the episodes whose success differs from that with noun and relation supplied, p of their exact McNemar "
        "test."
    ),
    by=("what",),
    rows=_language_rows,
    section=lambda group: "what sentences are read as (counts)" if group.get("group") == READ_AS else group.get("group"),
    columns=(
        cols.words("group", formats=DATA),
        cols.words("what", value=cols.get("title"), tex=cols.small_capitals),
        *(cols.of_relation(relation, "cell", str) for relation in (*cols.RELATIONS, ALL)),
        *(column for relation in (*cols.RELATIONS, ALL) for column in cols.end_columns(relation, cols.INTERVAL)),
        cols.RANGE,
        cols.numbers("n"),
        *cols.counts(wins="gained", losses="lost", data=cols.count),
        Column("p", "p", None, cols.p_value, tex=cols.power_of_ten, numeric=True),
    ),
)

# --- association and maps -------------------------------------------------------------------------

CUE_NAMES = {"clip": "CLIP", "histogram": "histogram", "extent": "extent"}


def _cues(group: Group) -> list[str]:
    return str(group.get("cues")).split(" + ")


TABLES["appearance"] = TableSpec(
    caption=(
        "Cues in the association cost of the reference agent with oracle grounding: features (CLIP), hue-saturation histograms, "
        "back-projected extents. Weights: shares, in this order, of best AUROC (same against different instances) on the split "
        "fitted on. Apart: pairs at least {s.admissibility.tau_m} m apart. Success: static gate, Wilson {confidence} "
        "intervals; wins, losses, exact McNemar p: against CLIP alone."
    ),
    by=("pairs", "cues", "fitted_on", "split"),
    section=lambda group: {ALL: "weights fitted on all pairs of the category", APART: "weights fitted on pairs that are apart"}[
        group.get("pairs")
    ],
    columns=(
        cols.words("pairs", formats=CSV_AND_MARKDOWN),
        cols.words("cues", value=lambda group: " + ".join(CUE_NAMES[cue] for cue in _cues(group))),
        cols.words("fitted", "fitted on", cols.get("fitted_on")),
        cols.words("split", "tested on"),
        cols.words("weights", value=lambda group: " + ".join(f"{group.get(cue):.2f}" for cue in _cues(group))),
        *cols.counts("same", "different"),
        *cols.rates(auroc="AUROC"),
        *cols.rates_by_relation(),
        *cols.end_columns(ALL, cols.INTERVAL),
        cols.RANGE,
        *cols.counts("wins", "losses", data=cols.one_decimal),
        cols.p_values(),
        cols.numbers("n", data=cols.one_decimal),
    ),
)


def _memory_arm(settings: Settings) -> str:
    arm = settings.arms[settings.comparisons.memory.arm]
    return f"{arm.system}, {arm.memory}"


TABLES["gate_sweep"] = TableSpec(
    caption=lambda gates, settings: (
        f"Static success of {_memory_arm(settings)}, by the association gate. It spans "
        f"{gates['success'].max() - gates['success'].min():.3f}. The smallest displacement that is asked about is "
        f"{settings.candidates.delta_min_m} m."
    ),
    columns=(
        cols.numbers("gate_m", "gate, m", "{:g}".format),
        cols.words("in_force", "in force", lambda group: "yes" if group.get("in_force") else ""),
        cols.numbers("n"),
        cols.numbers("success", data=cols.three),
        cols.numbers("success_low", data=cols.three, value=cols.get("low"), formats=DATA),
        cols.numbers("success_high", data=cols.three, value=cols.get("high"), formats=DATA),
        cols.RANGE,
    ),
    wide=False,
)

TABLES["read_as"] = TableSpec(
    caption=lambda rows, settings: (
        f"{_memory_arm(settings)} (static gate), on the past relations, asked as they are meant and as if the other had been "
        "said. Same answer: of the episodes answered as they are meant, those with the same point either way."
    ),
    columns=(
        cols.relation_column(),
        cols.relation_column("read_as", "read as"),
        *cols.counts("n", "answered", same="same answer", only_read_as="answered only as read"),
        *cols.counts("successes", successes_read_as="successes as read"),
    ),
    wide=False,
)

TABLES["fragments"] = TableSpec(
    caption=lambda rows, settings: (
        f"The targets in the maps of {_memory_arm(settings)}. Detected: in the answer's visit; objects a target: that its "
        "detections fall into; several: targets with more than one. Grounded: an object of the target is in the grounded set "
        "of every visit that it is in; missing: the others; each with the outcome on the static gate."
    ),
    columns=(
        cols.relation_column(),
        *cols.counts("n", seen="detected"),
        cols.numbers("objects", "objects a target", "{:.2f}".format),
        cols.numbers("several"),
        *(
            cols.numbers(f"{which}{suffix}", f"{which}{title}")
            for which in ("grounded", "missing")
            for suffix, title in (("", ""), ("_success", ", success"), ("_wrong", ", wrong"), ("_abstained", ", abstained"))
        ),
    ),
)


def _by_maps(name: str) -> Value:
    """Take the mean over maps."""
    return lambda group: math.fsum(row[name] * row["maps"] for row in group.rows) / _maps(group)


def _maps(group: Group) -> int:
    return sum(group.values("maps"))


def _dualmap_rows(objects: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Add the number of runs of each row, all of them where all scenes count."""
    runs = objects["run"][objects["run"] != ALL].nunique()
    of_scene = objects.groupby(["memory", "scene"])["run"].transform("size")
    return objects.assign(runs=of_scene.where(objects["scene"] != ALL, runs))


TABLES["dualmap"] = TableSpec(
    caption=(
        "DualMap's maps: how many keyframes they were made of, and how many objects they hold at the end, the mean over maps "
        "and runs, the least and the most of a map. Two visits: maps of single visits; maintained map: one map through two "
        "visits."
    ),
    by=("memory", "scene"),
    rows=_dualmap_rows,
    columns=(
        *cols.labels("memory", "scene"),
        cols.numbers("runs"),
        cols.numbers("maps", value=_maps),
        cols.numbers("frames", "keyframes", cols.one_decimal, _by_maps("frames")),
        cols.numbers("objects", data=cols.one_decimal, value=_by_maps("objects_mean")),
        cols.numbers("objects_min", "least", value=cols.least("objects_min")),
        cols.numbers("objects_max", "most", value=cols.most("objects_max")),
    ),
    wide=False,
)

THRESHOLD_TITLES = {
    "drift_tolerance_m": "allowed drift, m",
    "tau_m": "counts as moved from, m",
    "delta_min_m": "least applied displacement, m",
    "min_mask_px": "smallest recorded mask, px",
    "motion_m": "least motion, m",
    "validity_radius_m": "answer to free floor, m",
    "spawn_clearance_m": "start to change, m",
    "visible_px": "smallest visible mask, px",
}
"""The thresholds on pages."""


def _sensitivity_rows(margins: pd.DataFrame, settings: Settings) -> pd.DataFrame:
    """Repeat the settings: the one in force, all others, and all others by each value of each threshold."""
    others = margins[margins["in_force"] == 0]
    parts = [margins[margins["in_force"] == 1].assign(threshold="in force", value="")]
    parts.append(others.assign(threshold="all settings", value=""))
    for name in THRESHOLDS:
        ordered = others.sort_values(name, kind="stable")
        parts.append(ordered.assign(threshold=THRESHOLD_TITLES[name], value=[f"{value:g}" for value in ordered[name]]))
    return pd.concat(parts, ignore_index=True)


TABLES["sensitivity"] = TABLES["tolerances"] = TableSpec(
    caption=lambda margins, settings: (
        f"Static margin of memory ({settings.arms[settings.comparisons.memory.arm].memory} less "
        f"{settings.arms[settings.comparisons.memory.baseline].memory}, "
        f"{settings.arms[settings.comparisons.memory.arm].system}) under "
        "other thresholds of admissibility, of which every combination is a setting. The predictions stay the same. Margins: "
        "least and greatest of the settings with a value, over all trials that a setting admits (certified or not), and over "
        "the released episodes that it leaves."
    ),
    by=("threshold", "value"),
    rows=_sensitivity_rows,
    columns=(
        *cols.labels("threshold", "value"),
        cols.numbers("settings", value=cols.count_rows),
        cols.numbers("episodes_least", "trials, least", value=cols.least("episodes")),
        cols.numbers("episodes_most", "most", value=cols.most("episodes")),
        cols.numbers("margin_least", "margin, least", cols.signed, cols.least("margin")),
        cols.numbers("margin_greatest", "greatest", cols.signed, cols.most("margin")),
        cols.numbers("released_least", "released, least", value=cols.least("released")),
        cols.numbers("released_margin_least", "margin, least", cols.signed, cols.least("released_margin")),
        cols.numbers("released_margin_greatest", "greatest", cols.signed, cols.most("released_margin")),
    ),
)
