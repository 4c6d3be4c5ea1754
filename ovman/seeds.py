"""One root seed, spawned by name: every draw of the benchmark knows where its randomness comes from."""

from __future__ import annotations

import hashlib
import hmac
import zlib

import numpy as np


def sequence(root: int, *names: str | int) -> np.random.SeedSequence:
    """Return the seed sequence of `root` for the path `names`, e.g. ("trials", "FloorPlan201", 3, "tour")."""
    return np.random.SeedSequence(root, spawn_key=tuple(n if isinstance(n, int) else zlib.crc32(n.encode()) for n in names))


def generator(root: int, *names: str | int) -> np.random.Generator:
    """Return a generator seeded by `sequence`."""
    return np.random.default_rng(sequence(root, *names))


def conceal(nonce: str, text: str) -> str:
    """Return a digest of a text that nobody can foresee or recognise who does not know `nonce`."""
    return hmac.new(nonce.encode(), text.encode(), hashlib.sha256).hexdigest()


def tour_movers(of: str) -> tuple[str, ...]:
    """Return the path of the draws of the movers of a tour. of: id of the candidate or the episode of the tour."""
    return "mover", of, "tour"


def integer(root: int, *names: str | int) -> int:
    """Return a 31-bit seed for programs that take an integer, derived by `sequence`."""
    return int(sequence(root, *names).generate_state(1)[0] & 0x7FFFFFFF)
