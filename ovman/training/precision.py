"""The precision of a network's arithmetic while it is trained."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import torch

MULTIPLIES_IN_BFLOAT16 = ("avx512_bf16", "amx_bf16", "bf16")
"""Abilities of a processor, by torch's names. Without one bfloat16 is emulated, in ten times the time of single precision."""


def reduced(device: str, of_processor: Mapping[str, Any] | None = None) -> torch.autocast:
    """A context for the forward pass: bfloat16, or single precision on a processor that has no such products.

    device: "cpu" or "cuda". of_processor: the abilities of the processor, those of this one if not given.
    """
    known: Mapping[str, Any] = torch.cpu.get_capabilities() if of_processor is None else of_processor
    enabled = device != "cpu" or any(known.get(name) for name in MULTIPLIES_IN_BFLOAT16)
    return torch.autocast(device, torch.bfloat16, enabled=enabled)
