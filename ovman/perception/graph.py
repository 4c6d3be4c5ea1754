"""Networks as ONNX graphs: the one form in which a processor runs them without PyTorch.

A graph describes itself: its metadata say which network it is (`kind`), what its pictures are like (`facts`), and the weights and
libraries that it was made of. A torn or foreign file is refused.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

SCHEMA = "ovman-graph/1"
PICTURES, PIECES = "pictures", "pieces"
"""Names of the input of a graph of pictures and of the graph of a text tower."""
DESCRIPTION = "ovman"
"""Name of the description among a graph's metadata."""
Network = Callable[[np.ndarray], "tuple[np.ndarray, ...]"]
"""Runs pictures (N, 3, H, W) float32, or numbers (1, N) int64 of word pieces, through a network; its outputs in their order."""


class GraphError(ValueError):
    """A file that is not a graph of this project; says what it lacks."""


@dataclass(frozen=True, slots=True)
class Description:
    """The description of a graph.

    kind: "detector", "encoder" or "text"; facts: what preparing its input and reading its outputs needs; source: SHA-256 of the
    weights; made: versions of the libraries that made it.
    """

    kind: str
    facts: Mapping[str, Any]
    source: str
    made: Mapping[str, str]

    def text(self) -> str:
        """Return it as JSON."""
        return json.dumps({"schema": SCHEMA, "kind": self.kind, "facts": self.facts, "source": self.source, "made": self.made})

    @staticmethod
    def read(text: str) -> Description:
        """Read what `text` returned. Raises GraphError for anything else."""
        try:
            held = json.loads(text)
            schema, found = held.pop("schema"), Description(**held)
        except (ValueError, TypeError, KeyError, AttributeError):
            raise GraphError("its description cannot be read") from None
        if schema != SCHEMA:
            raise GraphError(f"it is of schema {schema}, not {SCHEMA}")
        return found


class Graph:
    """A described graph, run on one thread, so that its output does not depend on load.

    ONNX Runtime's own layouts are off: they block channels by the width of the processor's vectors, and sums follow the blocks.
    """

    def __init__(self, file: bytes) -> None:
        """Load a graph. Raises GraphError for a file that is damaged or not a described graph."""
        from onnxruntime import GraphOptimizationLevel, InferenceSession, SessionOptions

        options = SessionOptions()
        options.graph_optimization_level = GraphOptimizationLevel.ORT_ENABLE_EXTENDED
        options.log_severity_level = 3  # a quantised graph has constants that loading removes, with a warning each
        options.intra_op_num_threads = options.inter_op_num_threads = 1
        try:
            self._session = InferenceSession(file, options, providers=["CPUExecutionProvider"])
        except Exception:  # of onnxruntime's own classes, one for each kind of damage
            raise GraphError("it is not a whole ONNX graph") from None
        self._name = self._session.get_inputs()[0].name
        metadata = self._session.get_modelmeta().custom_metadata_map
        if DESCRIPTION not in metadata:
            raise GraphError("it has no description")
        self.description = Description.read(metadata[DESCRIPTION])

    def __call__(self, given: np.ndarray) -> tuple[np.ndarray, ...]:
        """Return the outputs of the network for its one input, as `Network`."""
        return tuple(self._session.run(None, {self._name: given}))
