"""The paper's Table "position" and the file that it is made from."""

from __future__ import annotations

import re

import pytest

from ovman.report.tables.position import POSITION, position_table, read
from ovman.report.tables.table import csv_text, latex, markdown

AXES = ("both_visits", "open_vocabulary", "change_relation", "empty_past")


def test_no_other_row_has_all_four_and_no_column_is_new():
    *others, ours = read().rows
    assert len(others) == 9 and ours.work == "OVMAN"
    assert all(getattr(ours, axis) == "yes" for axis in AXES)
    assert not any(all(getattr(one, axis) == "yes" for axis in AXES) for one in others)
    for axis in AXES[:2]:
        assert any(getattr(one, axis) == "yes" for one in others)


def test_the_table_is_the_file_in_every_format():
    table = position_table()
    lines = csv_text(table).splitlines()
    assert lines[0] == ",".join(("work", *AXES)) and len(lines) == 11
    assert "3D-SMNet,yes,no,partly,no (no navigation)" in lines and '"OpenIN, OO-NAV",yes,yes,no,no' in lines
    assert read().source in " ".join(markdown(table).split()) and latex(table, "position").count(r" \\") == 11


@pytest.mark.parametrize(
    ("change", "said"),
    [(("partly", "perhaps"), "change_relation"), (("source:", "sauce:"), "source"), (("rows:", "rows: ["), "yaml")],
)
def test_a_wrong_file_is_one_line(tmp_path, change, said):
    path = tmp_path / "position.yaml"
    path.write_text(POSITION.read_text(encoding="utf-8").replace(*change, 1), encoding="utf-8")
    with pytest.raises(ValueError, match=re.escape(said)) as caught:
        read(path)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)
