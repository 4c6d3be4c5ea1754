"""Networks as ONNX graphs. ONNX Runtime takes half to two thirds of torch's time on a processor."""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence
from typing import Any

OPSET = 17
NUMBER = "number"
"""Name of the dynamic batch axis."""


def exported(network: Any, shape: Sequence[int]) -> bytes:
    """A torch module, on the processor and in evaluation mode, as an ONNX file for pictures of one shape.

    shape: (N, C, H, W) of the pictures; N of 0 makes the batch axis dynamic.
    """
    import torch

    number, *picture = shape
    file = io.BytesIO()
    to: Any = file  # torch writes to one, and its types do not say so
    fast = torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # an operation without an ONNX equivalent
    try:
        with torch.inference_mode(), warnings.catch_warnings(action="ignore"):
            torch.onnx.export(
                network,
                (torch.zeros(number or 2, *picture),),
                to,
                dynamo=False,
                opset_version=OPSET,
                input_names=["pictures"],
                dynamic_axes=None if number else {"pictures": {0: NUMBER}},
            )
    finally:
        torch.backends.mha.set_fastpath_enabled(fast)
    return file.getvalue()


class Graph:
    """A graph of `exported`, run on one thread, so that its output does not depend on load. It equals torch's up to rounding."""

    def __init__(self, file: bytes) -> None:
        from onnxruntime import InferenceSession, SessionOptions

        options = SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._session = InferenceSession(file, options, providers=["CPUExecutionProvider"])

    def __call__(self, pictures: Any) -> tuple[Any, ...]:
        """The outputs of the network for a tensor of pictures of the graph's shape."""
        import torch

        return tuple(map(torch.from_numpy, self._session.run(None, {"pictures": pictures.contiguous().numpy()})))
