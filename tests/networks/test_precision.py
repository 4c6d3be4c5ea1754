"""A training step computes in bfloat16 only where the processor does."""

from __future__ import annotations

import pytest
import torch

from training.trainer import reduced_precision

pytestmark = pytest.mark.networks


@pytest.mark.parametrize(
    ("abilities", "kind"),
    [
        *(({"avx2": True, ability: True}, torch.bfloat16) for ability in ("avx512_bf16", "amx_bf16", "bf16")),
        ({}, torch.float32),
        ({"avx2": True, "avx512_f": True, "avx512_bf16": False, "amx_bf16": False}, torch.float32),
    ],
)
def test_products_are_in_bfloat16_where_the_processor_has_them_and_in_single_precision_elsewhere(abilities, kind):
    with reduced_precision("cpu", abilities):
        assert (torch.ones(2, 2) @ torch.ones(2, 2)).dtype == kind
