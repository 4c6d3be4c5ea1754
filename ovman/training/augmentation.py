"""Augmentation of crops: mirroring, shift, zoom, small rotation, brightness, blur, occlusion."""

from __future__ import annotations

from collections.abc import Callable

import torch
import torch.nn.functional as F

MIRRORED, BLURRED, HIDDEN = 0.5, 0.25, 0.3
"""Shares of mirrored, blurred and partly occluded crops."""
ZOOM, SHIFT, TURN_RAD = (0.75, 1.15), 0.12, 0.06
GAIN, OFFSET, NOISE = (0.7, 1.3), 0.08, 0.03
PATCH = (0.05, 0.22)
"""Half sides of an occluder as a share of the crop's side."""


def augmented(crops: torch.Tensor, generator: torch.Generator) -> torch.Tensor:
    """Augmented crops (B, 3, S, S) in [0, 1]; the same for a generator in the same state."""
    count, _, side, _ = crops.shape

    def uniform(low: float, high: float, *shape: int) -> torch.Tensor:
        return torch.rand(*shape, generator=generator, device=crops.device) * (high - low) + low

    zoom, mirror = uniform(*ZOOM, count), torch.where(uniform(0, 1, count) < MIRRORED, -1.0, 1.0)
    turn = torch.randn(count, generator=generator, device=crops.device) * TURN_RAD
    place = torch.zeros(count, 2, 3, device=crops.device)
    place[:, 0, 0], place[:, 0, 1] = zoom * mirror * turn.cos(), -zoom * turn.sin()
    place[:, 1, 0], place[:, 1, 1] = zoom * mirror * turn.sin(), zoom * turn.cos()
    place[:, :, 2] = uniform(-SHIFT, SHIFT, count, 2)
    grid = F.affine_grid(place, list(crops.shape), align_corners=False)
    out = F.grid_sample(crops, grid, padding_mode="border", align_corners=False)
    out = out * uniform(*GAIN, count, 1, 1, 1) + uniform(-OFFSET, OFFSET, count, 1, 1, 1)
    out = out + NOISE * uniform(0, 1, count, 1, 1, 1) * torch.randn(out.shape, generator=generator, device=crops.device)
    blurred = uniform(0, 1, count) < BLURRED
    if blurred.any():
        half = F.interpolate(out[blurred], scale_factor=0.5, mode="area")
        out[blurred] = F.interpolate(half, size=(side, side), mode="bilinear", align_corners=False)
    hidden = uniform(0, 1, count) < HIDDEN
    if hidden.any():
        out[hidden] = _hidden(out[hidden], uniform)
    return out.clamp(0, 1)


def _hidden(crops: torch.Tensor, uniform: Callable[..., torch.Tensor]) -> torch.Tensor:
    count, _, side, _ = crops.shape
    middle_x, middle_y = uniform(0, side, 2, count, 1, 1, 1)
    half_x, half_y = uniform(PATCH[0] * side, PATCH[1] * side, 2, count, 1, 1, 1)
    row = torch.arange(side, device=crops.device).view(1, 1, side, 1)
    column = torch.arange(side, device=crops.device).view(1, 1, 1, side)
    inside = ((column - middle_x).abs() < half_x) & ((row - middle_y).abs() < half_y)
    return torch.where(inside, uniform(0, 1, count, 3, 1, 1), crops)
