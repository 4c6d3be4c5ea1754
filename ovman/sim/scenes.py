"""Scenes by name: floor plans of iTHOR, homes that are drawn from a seed, and houses in files.

The name of a home says how it is drawn, and ends with the first digits of its digest, as does the name of a house in a file. So
records that name a scene need nothing else, and a home or file that has become another one is noticed.
"""

from __future__ import annotations

import re
from functools import lru_cache
from typing import Any

from ovman.settings.benchmark import HOUSE_NAME, HOUSES

HOME = re.compile(r"Home-(train|val|test)-([123])-([0-9]+(?:\.[0-9]+)*)-([0-9a-f]{8})")
HOUSE = re.compile(rf"{HOUSE_NAME}(?:-([0-9a-f]{{8}}))?")


class SceneError(ValueError):
    """A scene that cannot be loaded, or that the settings do not fit; one line: the scene, what is wrong, and the remedy."""

    says_all = True


@lru_cache(maxsize=4)
def load_scene(name: str) -> str | dict[str, Any]:
    """Return what a Controller loads for a scene: the name of a floor plan as it is, for others a house of ProcTHOR's schema.

    Raises SceneError for a house that is missing, or whose digest differs from that in the name.
    """
    # The generator and the engine's reader take a second to import, and floor plans need neither.
    if found := HOME.fullmatch(name):
        from ovman.homes.generate import digest_house, generate

        assets, rooms, seed, wanted = found.groups()
        house = generate(seed, int(rooms), assets)
        remedy = "draw the split again, or use the version of OVMAN that drew it"
    elif found := HOUSE.fullmatch(name):
        from ovman.homes.generate import digest_house, read_house

        stem, wanted = found.groups()
        path = HOUSES / f"{stem}.json"
        try:
            house = read_house(path)
        except ValueError as error:
            raise SceneError(f"{path}: {error}; mend it, or leave House-{stem} out of the split") from None
        except OSError as error:
            raise SceneError(f"{path}: {error.strerror}; put the house there, or leave House-{stem} out of the split") from None
        remedy = f"restore {path}, or draw the split again"
    else:
        return name
    if wanted not in (None, digest_house(house)):
        raise SceneError(f"{name}: the house has another digest, {digest_house(house)}; {remedy}")
    return house


def name_house(name: str) -> str:
    """Return the name of a house in a file with its digest, other names as they are."""
    found = HOUSE.fullmatch(name)
    if found is None or found[2]:
        return name
    from ovman.homes.generate import digest_house

    return f"{name}-{digest_house(load_scene(name))}"
