from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from ovman.report.show.labels import Box, Labels

places = st.tuples(st.floats(60, 540), st.floats(60, 540))


@given(places, st.floats(3, 12))
def test_a_label_is_beside_what_it_names_and_in_the_drawing(at, radius):
    box = Labels(600, 600).place(at, radius, "12–34", 12)
    assert box.overlap(Box.around(at, radius / 2**0.5, radius / 2**0.5)) == 0
    assert box.left >= 0 and box.top >= 0 and box.right <= 600 and box.bottom <= 600


def test_labels_of_one_place_do_not_lie_on_each_other():
    labels = Labels(600, 600)
    boxes = [labels.place((300, 300), 6, "7", 12) for _ in range(8)]
    assert all(a.overlap(b) == 0 for i, a in enumerate(boxes) for b in boxes[:i])


def test_a_label_keeps_off_what_is_kept():
    labels = Labels(600, 600)
    labels.keep((315, 300), 8)
    assert labels.place((300, 300), 6, "7", 12).overlap(Box.around((315, 300), 8, 8)) == 0
