"""A file that is not an OVMAN graph is refused."""

from __future__ import annotations

import numpy as np
import pytest

from ovman.perception.graph import Description, Graph, GraphError
from ovman.shipped import HOME

DESCRIPTION = Description("detector", {"stride": 32, "end2end": False, "classes": 1}, "0" * 64, {"torch": "2"})
WHOLE = (HOME / "models" / "detector.onnx").read_bytes()
PRODUCT = (
    b'\x08\x08:h\n\x1d\n\x08pictures\n\x02w0\x12\x08product0"\x03Mul\x12\x05small*\x16\x08\x03\x10\x01B\x02w0J\x0c'
    + np.ones(3, np.float32).tobytes()
    + b"Z\x16\n\x08pictures\x12\n\n\x08\x08\x01\x12\x04\n\x02\x08\x01b\x10\n\x08product0\x12\x04\n\x02\x08\x01B\x04\n\x00\x10\x11"
)
"""The ONNX file of a graph that multiplies its input by three ones, without a description."""


@pytest.mark.parametrize(
    ("spoilt", "says"),
    [
        (b"nothing of the kind", "not a whole ONNX graph"),
        (WHOLE[: len(WHOLE) // 4], "not a whole ONNX graph"),
        (PRODUCT, "no description"),
    ],
    ids=["text", "torn", "foreign"],
)
def test_a_file_that_is_no_graph_of_ours_is_refused(spoilt, says):
    with pytest.raises(GraphError, match=says):
        Graph(spoilt)


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("[]", "cannot be read"),
        ('{"schema": "ovman-graph/1", "kind": "detector"}', "cannot be read"),
        (DESCRIPTION.text().replace("ovman-graph/1", "ovman-graph/9"), "schema ovman-graph/9"),
    ],
)
def test_a_description_of_another_form_is_refused(text, says):
    with pytest.raises(GraphError, match=says):
        Description.read(text)
    assert Description.read(DESCRIPTION.text()) == DESCRIPTION
