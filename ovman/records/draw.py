"""Draws: fresh homes with certified episodes, the seed that they follow from, and how that seed came about."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Annotated, Literal

from pydantic import AfterValidator, Field

from ovman.records.record import Count, Name, Record, Text, optional

GENESIS, PERIOD_S = 1692803367, 3
"""Time of the first round of drand's chain "quicknet", in Unix seconds, and the seconds from one round to the next."""
TIME_FORM = "%Y-%m-%dT%H:%M:%SZ"


def utc(seconds: float) -> str:
    """Return Unix seconds as records have them: 2026-12-24T12:00:00Z. Texts of this form sort by time."""
    return datetime.fromtimestamp(seconds, UTC).strftime(TIME_FORM)


def _time(value: str) -> str:
    try:
        is_time = datetime.strptime(value, TIME_FORM).strftime(TIME_FORM) == value
    except ValueError:
        is_time = False
    if not is_time:
        raise ValueError(f"{value!r} is not a time; write it in UTC as 2026-12-24T12:00:00Z")
    return value


Time = Annotated[str, AfterValidator(_time)]
"""A second in UTC: 2026-12-24T12:00:00Z."""
Sha256 = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class Beacon(Record):
    """A round of drand's chain "quicknet", as its API answers: a public random value that nobody knows before its time.

    signature: of the network, hexadecimal. randomness: its SHA-256; some versions of the API leave it out.
    """

    round: int = Field(ge=1)
    signature: str = Field(pattern=r"^[0-9a-f]{96}$")
    randomness: Sha256 | None = optional()

    @property
    def value(self) -> str:
        """SHA-256 of the signature."""
        return hashlib.sha256(bytes.fromhex(self.signature)).hexdigest()

    @property
    def time(self) -> Time:
        """The second in which the round is published."""
        return utc(GENESIS + (self.round - 1) * PERIOD_S)

    @property
    def seed(self) -> str:
        """The seed of a draw."""
        return f"drand quicknet {self.round} {self.value}"


class SeedCommitment(Record):
    """A commitment to the seed of a draw, "ovman-seed/1". Published before the seed is told, it fixes the draw.

    time: of the commitment. closes: entries that were committed later do not count. sha256: of "{salt} {seed}". seed, salt: only
    in the file that is kept secret until `closes`.
    """

    schema_id: Literal["ovman-seed/1"] = Field("ovman-seed/1", alias="schema")
    split: Name
    homes: int = Field(ge=1)
    time: Time
    closes: Time
    sha256: Sha256
    seed: Text | None = optional()
    salt: Text | None = optional()

    @property
    def is_revealed(self) -> bool:
        """Whether seed and salt are there and have the digest."""
        return self.seed is not None and self.salt is not None and digest_seed(self.salt, self.seed) == self.sha256


def digest_seed(salt: str, seed: str) -> str:
    """Return the digest that a commitment publishes."""
    return hashlib.sha256(f"{salt} {seed}".encode()).hexdigest()


class Draw(Record):
    """The manifest of a draw, "ovman-draw/1".

    seed, split, homes: what the draw follows from. commitment, beacon: how the seed came about; neither if somebody chose it.
    scenes: names of the homes. n: number of episodes. files: SHA-256 by name. settings: digest of what the draw reads of the
    settings. code: digest of the code that drew, with the kernels of that machine. ovman, engine: versions.
    """

    schema_id: Literal["ovman-draw/1"] = Field("ovman-draw/1", alias="schema")
    split: Name
    seed: Text
    homes: int = Field(ge=1)
    commitment: SeedCommitment | None = optional()
    beacon: Beacon | None = optional()
    scenes: tuple[Name, ...]
    n: Count
    files: Mapping[Text, Sha256]
    settings: Text
    code: Text
    ovman: Text
    engine: Text

    @property
    def name(self) -> str:
        """The name of the draw: its split, and the first digits of the digest of its episodes."""
        return name_draw(self.split, self.files[EPISODES])


EPISODES, SCENES, SIGHTINGS, REJECTIONS = "episodes.jsonl", "scenes.jsonl", "sightings.jsonl", "rejections.csv"
"""Files of a draw."""


def name_draw(split: str, sha256: str) -> str:
    """Return the name of a draw. sha256: of its episodes."""
    return f"{split}-{sha256[:12]}"
