"""A training step computes in bfloat16 only where the processor does."""

from __future__ import annotations

import pytest
import torch

from training.trainer import reduced_precision

pytestmark = pytest.mark.networks


def product(**abilities):
    with reduced_precision("cpu", abilities):
        return torch.ones(2, 2) @ torch.ones(2, 2)


@pytest.mark.parametrize("ability", ["avx512_bf16", "amx_bf16", "bf16"])
def test_a_processor_with_products_in_bfloat16_computes_in_it(ability):
    assert product(avx2=True, **{ability: True}).dtype == torch.bfloat16


@pytest.mark.parametrize("abilities", [{}, {"avx2": True, "avx512_f": True, "avx512_bf16": False, "amx_bf16": False}])
def test_one_without_them_computes_in_single_precision(abilities):
    assert product(**abilities).dtype == torch.float32
