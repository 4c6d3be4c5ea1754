"""A cache of what lies beside it."""

from pathlib import Path

KEPT = Path(__file__).parent / "weights"


def try_to_load_from_cache(repository, name):
    path = KEPT / repository / name
    return str(path) if path.is_file() else None
