"""What was released follows from the released records, and a changed number is noticed."""

from __future__ import annotations

import json
import shutil
from collections import Counter

from tests.golden import compare

RELEASE = compare.ROOT / "data" / "ovman-embedded-v6"


def test_released_results_follow_from_the_released_records(capsys):
    assert compare.pure() == 0, capsys.readouterr().out


def test_a_changed_number_is_named(tmp_path, capsys):
    source = RELEASE / "predictions" / "main" / "joint.jsonl"
    results = tmp_path / "results"
    (results / "predictions").mkdir(parents=True)
    shutil.copy(source, results / "predictions")
    wanted = compare.rows_of(results)
    assert compare.report(wanted, compare.rows_of(results)) == 0
    first, *others = source.read_text().splitlines()
    changed = json.loads(first) | {"x": 99.5}
    (results / "predictions" / "joint.jsonl").write_text("\n".join([*others, json.dumps(changed)]))
    assert compare.report(wanted, compare.rows_of(results)) == 1
    assert f"x was {json.loads(first)['x']}, is 99.5" in capsys.readouterr().out


def test_the_order_and_the_files_of_rows_do_not_matter(tmp_path):
    for folder, files in (("one", {"a": "x\n", "b": "y\n"}), ("two", {"c": "y\nx\n"})):
        (tmp_path / folder / "scores").mkdir(parents=True)
        for name, letters in files.items():
            text = "".join(f'{{"row": "{letter}"}}\n' for letter in letters.split())
            (tmp_path / folder / "scores" / f"{name}.jsonl").write_text(text)
    one, two = (compare.rows_of(tmp_path / folder) for folder in ("one", "two"))
    assert one == two == {"scores": Counter({'{"row":"x"}': 1, '{"row":"y"}': 1})}


def test_oracles_are_nearly_always_right():
    rates = {}
    for name in ("static_rates", "embodied_rates"):
        for row in compare.records_of(RELEASE / "metrics" / "main" / f"{name}.csv"):
            rates[row["arm"], row["relation"]] = float(row["rate"])
    assert rates["positions_two_visits", "all"] >= 0.97
    assert rates["oracle_check", "all"] >= 0.98 and rates["two_visits_oracle_positions", "all"] >= 0.97
