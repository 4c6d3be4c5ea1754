"""A setting of the thresholds that the page moves, and the positions that it moves them between."""

from __future__ import annotations

from collections.abc import Mapping

from ovman.settings import Settings
from ovman.settings.explore import MOVED

Setting = Mapping[str, float]
"""Values by the names of `MOVED`."""


def in_force(settings: Settings) -> dict[str, float]:
    """The values that the settings have."""
    places = {name: place.split(".") for name, place in MOVED.items()}
    return {name: getattr(getattr(settings, section), last) for name, (section, last) in places.items()}


def positions(settings: Settings) -> dict[str, list[float]]:
    """The positions of each slider, ascending, the value in force among them; without those that trials were not measured for."""
    here, measured = in_force(settings), settings.measurement
    least, most = {"min_mask_px": measured.min_mask_px}, {"validity_radius_m": measured.answer_to_navigable_m}
    return {
        name: sorted(
            value
            for value in {*getattr(settings.explore, name), here[name]}
            if least.get(name, value) <= value <= most.get(name, value)
        )
        for name in MOVED
    }


def under(settings: Settings, setting: Setting) -> Settings:
    """The settings with these values in place of their own."""
    for name, value in setting.items():
        section, last = MOVED[name].split(".")
        changed = getattr(settings, section).model_copy(update={last: value})
        settings = settings.model_copy(update={section: changed})
    return settings
