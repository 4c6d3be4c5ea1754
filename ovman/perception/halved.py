"""The numbers of a graph in half the bytes, where nothing is lost.

Weights of half precision are multiplied channel by channel when layers are fused. A graph that has the weights and the factors
apart has the same numbers: the runtime multiplies them when it loads the graph. Needs the extra `networks`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

SMALL = 256
"""Numbers of an array that is left alone."""


def halved(graph: bytes, weights: Sequence[np.ndarray]) -> bytes:
    """A graph with the same numbers in its weights. weights: float16 arrays that it was made of; others are of no use."""
    import onnx
    from onnx import TensorProto, helper, numpy_helper

    model: Any = onnx.load_from_string(graph)
    by_shape: dict[tuple[int, ...], list[np.ndarray]] = {}
    for weight in weights:
        if weight.dtype == np.float16 and weight.size >= SMALL:
            by_shape.setdefault(weight.shape, []).append(weight)
    nodes, held = [], []
    for tensor in model.graph.initializer:
        array, name = numpy_helper.to_array(tensor), tensor.name
        parts = _parts(array, by_shape) if array.dtype == np.float32 and array.size >= SMALL else None
        if parts is None:
            held.append(tensor)
            continue
        half, factor = parts
        held.append(numpy_helper.from_array(half, f"{name}.half"))
        whole = name if factor is None else f"{name}.whole"
        nodes.append(helper.make_node("Cast", [f"{name}.half"], [whole], to=TensorProto.FLOAT))
        if factor is not None:
            held.append(numpy_helper.from_array(factor, f"{name}.factor"))
            nodes.append(helper.make_node("Mul", [whole, f"{name}.factor"], [name]))
    rest = list(model.graph.node)
    del model.graph.initializer[:], model.graph.node[:]
    model.graph.initializer.extend(held)
    model.graph.node.extend([*nodes, *rest])
    smaller: bytes = model.SerializeToString(deterministic=True)
    return smaller


def _parts(array: np.ndarray, weights: Mapping[tuple[int, ...], Sequence[np.ndarray]]) -> tuple[np.ndarray, Any] | None:
    """An array in half precision, and the factors of its channels, if any, that it has to be multiplied by; None without such."""
    with np.errstate(over="ignore"):
        half = array.astype(np.float16)
    if np.array_equal(half.astype(np.float32), array):
        return half, None
    for weight in weights.get(array.shape, ()):
        factor = _factor(array.reshape(len(array), -1), weight.astype(np.float32).reshape(len(array), -1))
        if factor is not None:
            return weight, factor.reshape(-1, *(1,) * (array.ndim - 1))
    return None


def _factor(array: np.ndarray, weight: np.ndarray) -> np.ndarray | None:
    """The factors (channels,) with which `weight` (channels, N) is `array` to the last bit; None if there are none."""
    largest = np.abs(weight).argmax(axis=1)[:, None]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        quotient = np.take_along_axis(array, largest, 1) / np.take_along_axis(weight, largest, 1)
    quotient = np.where(np.isfinite(quotient), quotient, np.float32(0))
    found = np.full(len(array), np.nan, np.float32)
    for near in (quotient, np.nextafter(quotient, np.float32(np.inf)), np.nextafter(quotient, np.float32(-np.inf))):
        right = (weight * near == array).all(axis=1)
        found = np.where(right, near[:, 0], found)
    return None if np.isnan(found).any() else found
