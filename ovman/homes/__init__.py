"""Homes that are drawn from a seed, as houses of ProcTHOR's schema: `generate.generate`, `check.check` and `generate.draw`."""
