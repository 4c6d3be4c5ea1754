"""How the seed of a draw comes about: a commitment that is revealed later, or a public beacon's value of a later time."""

from __future__ import annotations

import hashlib
import secrets
import sys
import time
from pathlib import Path
from typing import TypeVar

from ovman.atomic import replacing
from ovman.draws import DrawError
from ovman.records.draw import Beacon, SeedCommitment, digest_seed, utc
from ovman.records.record import Record

PUBLIC, SECRET = "commitment.json", "secret.json"
"""Files of a commitment: the one to publish, and the one with seed and salt."""
KEY = (
    "83cf0f2896adee7eb8b5f01fcad3912212c437e0073e911fb90022d3e760183c8c4b450b6a0a6c3ac6a5776a2d106451"
    "0d1fec758c921cc22b0e17e63aaf4bcb5ed66304de9cf809bd274ca73bab4af5a6e9c76a4bc09e76eae8991ef5ece45a"
)
"""Public key of drand's chain "quicknet", 52db9ba70e0cc0f6eaf7803dd07447a1f5477735fd3f661792ba94600c84e971."""
R = TypeVar("R", bound=Record)
SUITE = b"BLS_SIG_BLS12381G1_XMD:SHA-256_SSWU_RO_NUL_"


def commit(split: str, homes: int, closes: str, out: Path, seed: str | None = None) -> SeedCommitment:
    """Write a commitment to the seed of a draw into a new folder; seed: random if None. DrawError for a wrong time or folder."""
    if out.exists():
        raise DrawError(f"--out: {out} is there already; name a new folder")
    salt, seed, now = secrets.token_hex(16), seed or secrets.token_hex(16), utc(time.time())
    value = {"schema": "ovman-seed/1", "split": split, "homes": homes, "time": now, "closes": closes}
    public = SeedCommitment.from_json(value | {"sha256": digest_seed(salt, seed)}, "ovman commit")
    if closes <= now:
        raise DrawError(f"--closes: {closes} has passed; write a later time")
    with replacing(out) as partial:
        partial.mkdir()
        (partial / PUBLIC).write_text(public.to_line(), encoding="utf-8")
        (partial / SECRET).touch(mode=0o600)
        (partial / SECRET).write_text(public.model_copy(update={"seed": seed, "salt": salt}).to_line(), encoding="utf-8")
    return public


def read_secret(path: Path) -> SeedCommitment:
    """Return a commitment with its seed and salt. DrawError or RecordError, in one line, for another file."""
    found = _read(SeedCommitment, path, "a commitment with its seed")
    if found.seed is None or found.salt is None:
        raise DrawError(f"{path}: has no seed and salt; name the file {SECRET} of the commitment")
    check_commitment(found, str(path))
    return found


def check_commitment(found: SeedCommitment, place: str) -> None:
    """Raise DrawError if a revealed commitment is to another seed."""
    if not found.is_revealed:
        raise DrawError(f"{place}: sha256: seed and salt have another digest; use the seed that was committed")


def read_beacon(path: Path) -> Beacon:
    """Return a round of drand that its network signed. DrawError or RecordError, in one line, for another value."""
    found = _read(Beacon, path, "drand's answer for a round")
    check_beacon(found, str(path))
    return found


def check_beacon(found: Beacon, place: str) -> None:
    """Raise DrawError if the network did not sign the value for its round."""
    remedy = "copy the answer of https://api.drand.sh/v2/beacons/quicknet/rounds/ROUND"
    if found.randomness not in (None, found.value):
        raise DrawError(f"{place}: randomness: is not the SHA-256 of the signature; {remedy}")
    if not _is_signed(found.round, bytes.fromhex(found.signature)):
        raise DrawError(f"{place}: signature: is not drand's for round {found.round} of quicknet; {remedy}")


def _is_signed(number: int, signature: bytes) -> bool:
    """Return whether the network signed a round: BLS on the group G1, RFC 9380, the round's number as the message."""
    limit = sys.getrecursionlimit()
    try:
        return _verify(number, signature)
    finally:
        sys.setrecursionlimit(limit)  # py_ecc raises it so far that deeply nested JSON would crash the process


def _verify(number: int, signature: bytes) -> bool:
    from py_ecc.bls.g2_primitives import subgroup_check
    from py_ecc.bls.hash_to_curve import hash_to_G1
    from py_ecc.bls.point_compression import decompress_G1, decompress_G2
    from py_ecc.optimized_bls12_381 import FQ12, G2, final_exponentiate, neg, pairing

    key = decompress_G2((int(KEY[:96], 16), int(KEY[96:], 16)))
    message = hash_to_G1(hashlib.sha256(number.to_bytes(8, "big")).digest(), SUITE, hashlib.sha256)
    try:
        point = decompress_G1(int.from_bytes(signature, "big"))
    except ValueError:
        return False
    # Without the check of the subgroup, further signatures of the same round would pass, and one could choose among them.
    if not subgroup_check(point):
        return False
    both = pairing(G2, point, final_exponentiate=False) * pairing(neg(key), message, final_exponentiate=False)
    return bool(final_exponentiate(both) == FQ12.one())


def _read(kind: type[R], path: Path, what: str) -> R:
    """Return the one record of a file."""
    try:
        return kind.parse(path.read_bytes(), str(path))
    except OSError as error:
        raise DrawError(f"{path}: {error.strerror}; name a file with {what}") from None
