"""Metrics whose figures are the paper's own, with the columns of the real files: every test must hold on them."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from itertools import product
from pathlib import Path

import pandas as pd

from ovman.report.paper_comparison.comparison import RELATIONS
from ovman.report.paper_comparison.metrics import ALL, Metrics, arms_by_row
from ovman.report.paper_comparison.paper import Figure, Paper
from ovman.settings.sensitivity import THRESHOLDS
from tests.arms import CONFIG

Files = dict[str, list[dict[str, str]]]
SEEDS = ("0", "1", "2")
EVERY = (*RELATIONS, ALL)
DUALMAP = tuple(f"{rung}dualmap_{memory}" for rung, memory in product(("", "grounding_"), ("maintained", "two_visits")))
STATIC = tuple(CONFIG.paper.static)
READINGS = ("", "_any", "_nearest")
"""Endings of the arms, and of their rows, by the reading of what is handed over."""
EMBODIED = ("cow", "single_visit_embodied", "two_visits_embodied", "two_visits_oracle_positions", "oracle_check")
ARMS_BY_ROW = arms_by_row(CONFIG.comparisons, CONFIG.paper)
ROW_OF = {arm: row for row, arm in ARMS_BY_ROW.items() if row != "agent"}
"""The row of the paper by arm: "static.two"."""
VERDICTS = ("success", "abstain", "elsewhere", "near_miss", "wrong_instance")


def printed(row: str) -> str:
    """The row of the paper with the figures that a row of ours, "static.grounding_two_any", is compared with."""
    return row.removesuffix("_any").removesuffix("_nearest").replace("maintained", "one")


def number(figure: Figure) -> float:
    """A value, a little below a bound, or the middle of a range."""
    if figure.value is not None:
        return figure.value
    return figure.below / 10 if figure.below is not None else (figure.low + figure.high) / 2


def metrics_of(files: Mapping[str, list[dict[str, str]]]) -> Metrics:
    """Metrics of rows by the names of the files; a cell that a row lacks is empty."""
    return Metrics({name.removesuffix(".csv"): _frame(rows) for name, rows in files.items()}, ARMS_BY_ROW)


def written_files(directory: Path, files: Files) -> list[Path]:
    """The files in a directory, as the stages that make metrics write them."""
    for name, rows in files.items():
        _frame(rows).to_csv(directory / name, index=False, lineterminator="\n")
    return [directory / name for name in files]


def _frame(rows: list[dict[str, str]]) -> pd.DataFrame:
    """The frame of a list of rows, made once a list."""
    if id(rows) not in _FRAMES:
        columns = list(dict.fromkeys(column for row in rows for column in row))
        body = [[row.get(column, "") for column in columns] for row in rows]
        _FRAMES[id(rows)] = rows, pd.DataFrame(body, columns=columns, dtype=object)
    return _FRAMES[id(rows)][1]


_FRAMES: dict[int, tuple[list[dict[str, str]], pd.DataFrame]] = {}


@cache
def papers_files() -> Files:
    """Rows by the name of the file. What the paper does not print is filled in so that it contradicts nothing printed."""
    paper = Paper.read()

    def get(key: str, otherwise: float | None = None) -> float:
        if key in paper:
            return number(paper[key])
        assert otherwise is not None, key
        return otherwise

    n = {relation: get(f"taxonomy.episodes.{relation}") for relation in EVERY}

    def rate(arm: str, relation: str) -> dict[str, str]:
        value = get(f"{printed(ROW_OF[arm])}.{relation}")
        return _row(
            arm=arm,
            relation=relation,
            n=n[relation],
            successes=value * n[relation],
            rate=value,
            low=max(0, value - 0.05),
            high=min(1, value + 0.05),
            spl="" if arm == "cow" else get(f"{ROW_OF[arm]}.spl", 0.9),
        )

    def compared(arm: str, baseline: str, seed: str, relation: str, kind: str) -> dict[str, str]:
        p = get(f"{kind}_p_{relation}", 0.5)
        return _row(
            arm=arm,
            baseline=baseline,
            seed=seed,
            relation=relation,
            n=n[relation],
            wins=get(f"{kind}_wins", 60),
            losses=get(f"{kind}_losses", 10),
            p=p,
            p_holm="" if relation == ALL else p,
        )

    def cow_compared(seed: str, relation: str) -> dict[str, str]:
        p = get("cow_p") if relation == ALL else 0.01
        return _row(
            arm="two_visits_embodied",
            baseline="cow",
            seed=seed,
            relation=relation,
            n=n[relation],
            wins=get("cow_wins"),
            losses=get("cow_losses"),
            p=p,
            p_holm="" if relation == ALL else p,
        )

    def own_task(seed: str) -> dict[str, str]:
        own, rate = get("cow_any_instance"), get("embodied.cow.all")
        return _row(arm="cow", seed=seed, relation=ALL, n=n[ALL], own_rate=own, rate=rate, gap=own - rate, p=1e-10)

    def paired(arm: str, baseline: str, run: str, against: str, relation: str) -> dict[str, str]:
        """The worst pairing is the first; the others make up for it so that the mean is the difference of the means."""
        mean = get(f"{printed(ROW_OF[arm])}.{relation}") - get(f"{printed(ROW_OF[baseline])}.{relation}")
        handed = arm.startswith("grounding_dualmap")
        worst = get(f"dualmap_worst_pairing{'' if relation == ALL else '_former'}") if handed else mean
        first, pairings = (run, against) == ("0", "0"), 9 if handed else 3
        return _row(
            arm=arm,
            baseline=baseline,
            arm_run=run,
            baseline_run=against,
            relation=relation,
            difference=worst if first else (mean * pairings - worst) / (pairings - 1),
            p=0.5 if handed else 1e-9,
        )

    def navigated(arm: str, prefix: str, index: int) -> dict[str, str]:
        return _row(
            arm=arm,
            seed=SEEDS[index],
            relation=ALL,
            n=n[ALL],
            sr=get(f"{prefix}_seed_{index}"),
            spl_given_success=get("spl_given_success"),
            lost=get("lost_by_navigating"),
            gained=get("gained_by_navigating"),
        )

    def difficulty(by: str, group: str, arm: str, of: float, value: float) -> dict[str, str]:
        low, high = max(0.0, value - 0.1), min(1.0, value + 0.1)
        return _row(by=by, group=group, arm=arm, n=of, successes=value * of, rate=value, low=low, high=high)

    rungs = {
        "own": {"arm": "two_visits", "rate": get("static.two.all"), "low": 0.35, "high": 0.48},
        "oracle grounding": {
            "rate": get("static.grounding_two.all"),
            "low": 0.41,
            "high": 0.54,
            "arm": "grounding_two_visits",
            "gain": get("rung_grounding"),
            "gained": get("handover_wins"),
            "lost": get("handover_losses"),
            "p": get("handover_p"),
        },
        "oracle positions": {
            "rate": get("static.positions_two.all"),
            "low": 0.97,
            "high": 1.0,
            "arm": "positions_two_visits",
            "gain": get("rung_mapping"),
            "gained": 115,
            "lost": 2,
            "p": 1e-20,
        },
        "answer given": {"rate": get("answer_given"), "gain": get("rung_selection"), "gained": 1, "lost": 0, "p": 1},
    }
    groups = (("2", "two"), ("3", "three"), ("4+", "more"))
    return {
        "static_rates.csv": [rate(arm, relation) for arm in STATIC for relation in EVERY],
        "embodied_rates.csv": [rate(arm, relation) for arm in EMBODIED for relation in EVERY],
        "significance.csv": [
            *(compared("two_visits", "single_visit", "0", relation, "static") for relation in EVERY),
            *(
                compared("two_visits_embodied", "single_visit_embodied", seed, relation, "embodied")
                for seed in SEEDS
                for relation in EVERY
            ),
            *(cow_compared(seed, relation) for seed in SEEDS for relation in EVERY),
            *controls_compared(),
        ],
        "controls.csv": controls(),
        "split_significance.csv": compared_on_splits(),
        "own_task.csv": [own_task(seed) for seed in SEEDS],
        "pairings.csv": [
            *(
                paired(f"grounding_dualmap_two_visits{reading}", f"grounding_dualmap_maintained{reading}", run, against, relation)
                for reading in READINGS
                for run, against in product(SEEDS, SEEDS)
                for relation in (ALL, "former")
            ),
            *(paired("two_visits", baseline, "0", run, ALL) for baseline in DUALMAP[:2] for run in SEEDS),
            *(
                _row(
                    arm="two_visits",
                    baseline=ARMS_BY_ROW["controls.relation_withheld"],
                    arm_run="0",
                    baseline_run=run,
                    relation=ALL,
                    difference=0.2,
                    p=1e-9,
                )
                for run in SEEDS
            ),
        ],
        "seeds.csv": [
            _row(arm="cow", relation=relation, seed=seed, n=n[relation], rate=rate)
            for relation, key, middle in ((ALL, "cow", "embodied.cow.all"), ("former", "cow_former", "embodied.cow.former"))
            for seed, rate in zip(SEEDS, (get(f"{key}_least"), get(middle), get(f"{key}_greatest")), strict=True)
        ],
        "navigation.csv": [
            navigated(arm, prefix, index)
            for arm, prefix in (("single_visit_embodied", "one"), ("two_visits_embodied", "two"))
            for index in range(3)
        ],
        "taxonomy.csv": [
            *(
                _row(
                    arm="two_visits",
                    verdict=verdict,
                    relation=relation,
                    episodes=get(f"taxonomy.{verdict}.{relation}"),
                    n=n[relation],
                    embodied="",
                    seed="",
                )
                for verdict in VERDICTS
                for relation in EVERY
            ),
            *(
                _row(
                    arm="two_visits",
                    verdict="lost_in_navigation",
                    relation=relation,
                    n=n[relation],
                    embodied="two_visits_embodied",
                    episodes=get(f"taxonomy.lost_in_navigation.{relation}"),
                    seed=seed,
                )
                for seed in SEEDS
                for relation in EVERY
            ),
        ],
        "difficulty.csv": [
            *(
                difficulty("instances", group, "two_visits", get(f"episodes_with_{key}"), get(f"success_with_{key}"))
                for group, key in groups
            ),
            difficulty("scene", "FloorPlan1", "two_visits", 10, get("worst_scene")),
            difficulty("scene", "FloorPlan7", "two_visits", 10, get("best_scene")),
            *(
                difficulty("scene", scene, f"grounding_two_visits{reading}", 10, value)
                for reading in READINGS
                for scene, value in (("FloorPlan1", get("worst_scene_grounding")), ("FloorPlan7", 0.9))
            ),
        ],
        "readings.csv": [
            _row(
                arm=f"grounding_two_visits{reading}",
                relation=ALL,
                gained=get("handover_wins"),
                lost=get("handover_losses"),
                p=get("handover_p"),
            )
            for reading in READINGS
        ],
        "dualmap.csv": [
            _row(scene=scene, memory="two visits", run=run, objects_mean=get(f"dualmap_objects_{key}"))
            for scene, key in (("FloorPlan1", "least"), ("FloorPlan7", "degenerate"), ("FloorPlan10", "most"))
            for run in SEEDS
        ],
        "budget.csv": [_row(rung=rung, relation=ALL, n=n[ALL], **cells) for rung, cells in rungs.items()],
        "language.csv": [
            _row(what=what, relation=ALL, read_as="", n=n[ALL], rate=get(key), origin="made up")
            for what, key in (
                ("both", "parser_accuracy"),
                ("noun_inferred", "success_supplied"),
                ("inferred", "success_inferred"),
            )
        ],
        "rescued.csv": [
            _row(
                arm="two_visits_embodied",
                seed=seed,
                relation=relation,
                gained=get("gained_by_navigating"),
                rescued=rescued,
                nearest_m=get("rescued_nearest_m"),
                farthest_m=get("rescued_farthest_m"),
            )
            for seed in SEEDS
            for relation, rescued in (("moving", 5.0), ("stable", 4.0), (ALL, get("rescued_stops")))
        ],
        "appearance.csv": [
            _row(pairs=pairs, cues="clip", fitted_on="", split="multi", relation=ALL, auroc=0.5, rate=get("multi_success"))
            for pairs in (ALL, "apart")
        ]
        + [
            _row(
                pairs=pairs,
                cues=cues,
                fitted_on="multi",
                split=split,
                relation=ALL,
                auroc=get("multi_best_auroc" if split == "multi" else "multi_held_out_auroc"),
                rate=get("multi_success_with_appearance"),
            )
            for pairs in (ALL, "apart")
            for split in ("main", "multi")
            for cues in ("clip + histogram", "clip + histogram + extent")
        ],
        "fragments.csv": [
            _row(
                relation=relation,
                seen=30,
                several=20,
                objects=2.0 if relation == "moving" else 1.2,
                grounded=10,
                grounded_wrong=3,
                missing=20,
                missing_wrong=17,
            )
            for relation in EVERY
        ],
        "gate_sweep.csv": [
            _row(
                gate_m=gate_m,
                in_force=in_force,
                delta_min_m=get("gate_delta_min_m"),
                success=success,
                low=success - 0.05,
                high=success + 0.05,
            )
            for gate_m, in_force, success in (
                (get("gate_least_m"), "0", 0.4),
                (get("gate_in_force_m"), "1", 0.4 + get("gate_span")),
                (get("gate_greatest_m"), "0", 0.41),
            )
        ],
        "read_as.csv": [
            _row(relation="removed", answered=23, same=23, only_read_as=0, successes=19, successes_read_as=19),
            _row(relation="former", answered=28, same=28, only_read_as=0, successes=17, successes_read_as=17),
        ],
        "sensitivity.csv": [
            _row(
                setting=k,
                in_force="0" if k else "1",
                margin=margin,
                released_margin=margin,
                **dict.fromkeys(THRESHOLDS, 1 + k % 2),
            )
            for k in range(int(get("admissibility_settings")) + 1)
            for margin in [get("static_margin_least" if k % 2 else "static_margin_greatest")]
        ],
        "backprojection.csv": [
            _row(
                scene="FloorPlan1",
                object=f"Chair|{k}",
                mask="true",
                median_box_m=0.01 * k,
                ray_box_m=get("single_ray_worst_m") / (k + 1),
            )
            for k in range(5)
        ],
    }


CHANCE = 0.45


def controls() -> list[dict[str, str]]:
    """Controls as statements of our own say they are; the paper has none."""
    rates = {"depth": 0.9, "depth_driving": 0.9, "category": CHANCE, "joint": 0.95, "joint_driving": 0.95}
    plain = {"joint_noun_withheld": 0.9}  # on main what changed is plain without the noun
    return [
        _row(
            split=split,
            kind=CONFIG.arms[arm].kind,
            arm=arm,
            control=str(int(CONFIG.arms[arm].control)),
            relation=relation,
            n=10,
            rate=(rates | plain if split == "main" else rates).get(entry.role, 0.1),
            low=0.0,
            high=1.0,
            interval="wilson",
            chance=CHANCE,
            chance_of_change=1.0,
            spl="",
            least="",
            greatest="",
        )
        for split in [name for name, one in CONFIG.splits.items() if one.in_main_job]
        for arm, entry in CONFIG.comparisons.controls.items()
        for relation in EVERY
    ]


def compared_on_splits() -> list[dict[str, str]]:
    """Every pair that is tested on every split, as a clear difference."""
    return [
        _row(split=split, arm=pair.arm, baseline=pair.baseline, seed=seed, n=10, wins=9, losses=0, p=1e-9)
        for split in [name for name, one in CONFIG.splits.items() if one.in_main_job]
        for pair in CONFIG.comparisons.pairs.values()
        if pair.every_split
        for seed in (SEEDS if CONFIG.arms[pair.arm].kind == "embodied" else SEEDS[:1])
    ]


def controls_compared() -> list[dict[str, str]]:
    """Every pair of arms of which one is a control, as a clear difference."""
    arms = CONFIG.arms
    pairs = [pair for pair in CONFIG.comparisons.pairs.values() if arms[pair.arm].control or arms[pair.baseline].control]
    return [
        _row(arm=pair.arm, baseline=pair.baseline, seed=seed, relation=ALL, n=10, wins=9, losses=0, p=1e-9, p_holm="")
        for pair in pairs
        for seed in (SEEDS if CONFIG.arms[pair.arm].kind == "embodied" else SEEDS[:1])
    ]


def _row(**cells: float | str) -> dict[str, str]:
    return {name: value if isinstance(value, str) else f"{value:.12g}" for name, value in cells.items()}
