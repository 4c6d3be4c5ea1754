"""A network as a graph that ONNX Runtime runs on a processor, in half to two thirds of the time that torch takes there."""

from __future__ import annotations

import io
import warnings
from collections.abc import Sequence
from typing import Any

OPSET = 17
NUMBER = "number"
"""The name of an axis that is as long as it needs to be."""


def exported(network: Any, shape: Sequence[int]) -> bytes:
    """What `network`, a module of torch on the processor and in evaluation, does with pictures of one shape, as an ONNX file.

    shape: (N, C, H, W) of the pictures; N of 0 is any number of them.
    """
    import torch

    number, *picture = shape
    file = io.BytesIO()
    to: Any = file  # torch writes to one, and its types do not say so
    fast = torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # one operation of torch's own, which no graph has
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
    """What the file of `exported` says, on one thread, so that it gives the same numbers whatever else the processor does. They
    are those of torch up to rounding.
    """

    def __init__(self, file: bytes) -> None:
        from onnxruntime import InferenceSession, SessionOptions

        options = SessionOptions()
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        self._session = InferenceSession(file, options, providers=["CPUExecutionProvider"])

    def __call__(self, pictures: Any) -> tuple[Any, ...]:
        """The tensors that the network gives for pictures, a tensor of the shape that the graph is for."""
        import torch

        return tuple(map(torch.from_numpy, self._session.run(None, {"pictures": pictures.contiguous().numpy()})))
