"""The verdict on a run: success (Eq. 4), SPL (Eq. 5), and success on an agent's own task."""

from __future__ import annotations

from ovman.models.relation import Relation
from ovman.models.run import Measured
from ovman.models.settings.benchmark import Success
from ovman.task import success


def judged(run: Measured, relation: Relation, constants: Success) -> bool:
    """Success (Eq. 4) of a measured run; a run that did not stop is a failure."""
    return run.outcome == "stopped" and success(run.measurement, relation, constants)


def any_instance(run: Measured, constants: Success) -> bool:
    """Whether a run ends within R of any instance of the category and with it in sight, the relation aside.

    A run that did not stop is a failure.
    """
    if run.outcome != "stopped":
        return False
    return any(
        found.box_distance_m <= constants.radius_m
        and any(found.visible_px[pitch] >= constants.visible_px for pitch in constants.sweep_deg)
        for found in (run.instances or {}).values()
    )
