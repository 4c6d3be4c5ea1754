"""Graphs of the networks that torch has. Needs the extra `networks`; what runs a graph is `ovman.perception.graph`."""

from __future__ import annotations

import io
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception import towers, yolo
from ovman.perception.graph import PICTURES, Description, described
from ovman.perception.halved import halved
from ovman.perception.weights import sha256

OPSET = 17
SIDE_PX = 64
"""Side of the picture that a detector is shown while it is exported; its graph takes any multiple of its stride."""
DETECTOR_LIBRARIES = ("torch", "onnx", "ultralytics")
ENCODER_LIBRARIES = ("torch", "onnx", "open_clip_torch")
ANY = ("number", "channels", "height", "width")
"""Names of a graph's axes."""


def detector_graph(network: Any, weights: Path) -> bytes:
    """The graph of a detector of ultralytics for one picture of any size. weights: the file that its numbers come from."""
    kept = _arrays(network)
    graph = exported(yolo.running(network), (1, 3, SIDE_PX, SIDE_PX), (2, 3))
    description = Description("detector", asdict(yolo.facts_of(network)), sha256(weights), made_by(DETECTOR_LIBRARIES))
    return described(halved(graph, kept), description)


def encoder_graph(network: Any, of: towers.Architecture, weights: Path) -> bytes:
    """The graph of an image tower for any number of crops. weights: the file that its numbers come from."""
    facts, kept = towers.facts_of(network, of), _arrays(network)
    tower = network.float().eval().visual
    graph = exported(tower, (2, 3, facts.side_px, facts.side_px), (0,))
    return described(halved(graph, kept), Description("encoder", asdict(facts), sha256(weights), made_by(ENCODER_LIBRARIES)))


def made_by(libraries: Sequence[str]) -> dict[str, str]:
    """The versions of distributions by their names."""
    return {name: version(name) for name in libraries}


def exported(network: Any, shape: Sequence[int], free: Sequence[int]) -> bytes:
    """A torch module, on the processor and in evaluation mode, as an ONNX file.

    shape: (N, C, H, W) of the pictures that it is shown; free: the axes that may be of any size.
    """
    import torch

    file = io.BytesIO()
    to: Any = file  # torch writes to one, and its types do not say so
    fast = torch.backends.mha.get_fastpath_enabled()
    torch.backends.mha.set_fastpath_enabled(False)  # an operation without an ONNX equivalent
    try:
        with torch.inference_mode(), warnings.catch_warnings(action="ignore"):
            torch.onnx.export(
                network,
                (torch.zeros(*shape),),
                to,
                dynamo=False,
                opset_version=OPSET,
                input_names=[PICTURES],
                dynamic_axes={PICTURES: {axis: ANY[axis] for axis in free}},
            )
    finally:
        torch.backends.mha.set_fastpath_enabled(fast)
    return file.getvalue()


def _arrays(network: Any) -> list[np.ndarray]:
    """The tensors of a network that half precision holds."""
    state: Mapping[str, Any] = network.state_dict()
    with np.errstate(over="ignore"):
        pairs = [(whole, whole.astype(np.float16)) for whole in (tensor.cpu().float().numpy() for tensor in state.values())]
    return [half for whole, half in pairs if np.array_equal(half.astype(np.float32), whole)]
