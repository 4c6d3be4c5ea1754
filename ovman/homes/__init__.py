"""Homes that are drawn from a seed, as houses of ProcTHOR's schema (docs/homes.md)."""

from ovman.homes.check import Report, check
from ovman.homes.generate import ABUNDANT, Home, draw, generate, named

__all__ = ["ABUNDANT", "Home", "Report", "check", "draw", "generate", "named"]
