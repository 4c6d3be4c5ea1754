"""The page of `ovman explore`: one HTML file that works without a server."""

from __future__ import annotations

import json
from importlib.resources import files
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from ovman.settings import Settings
from ovman.settings.explore import MOVED

LABELS = {
    "drift_tolerance_m": "drift tolerance",
    "tau_m": "τ",
    "delta_min_m": "Δ min",
    "min_mask_px": "smallest mask",
    "validity_radius_m": "validity radius",
    "radius_m": "R",
}
KINDS = {
    "static": ("Static gate", "a point within R of the answer, on the episodes that are left"),
    "embodied": ("Embodied", "a stop that succeeds (Eq. 4), mean over seeds"),
}


def page(data: dict[str, Any], settings: Settings) -> str:
    """The page for the data of `ovman.explore.encoding.encoded`. Equal data give equal text."""
    loader = PackageLoader("ovman.explore", "templates")
    templates = Environment(loader=loader, autoescape=True, undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    script = files("ovman.explore").joinpath("templates", "explore.js").read_text(encoding="utf-8")
    kinds = {arm["kind"] for arm in data["arms"]}
    # A text in it may not end the element that it stands in.
    text = json.dumps(data, separators=(",", ":")).replace("</", "<\\/")
    return templates.get_template("explore.html").render(
        split=data["split"],
        data=data,
        sliders=[(name, LABELS[name], key) for name, key in MOVED.items()],
        kinds=[(kind, *words) for kind, words in KINDS.items() if kind in kinds],
        drawn=settings.candidates.delta_min_m,
        measured_px=settings.measurement.min_mask_px,
        measured_m=settings.measurement.answer_to_navigable_m,
        json=text,
        script=script,
    )
