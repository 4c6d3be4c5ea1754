"""A placed instance that does not stay: through the real engine, from the candidate to the verdict."""

from __future__ import annotations

from ovman.generation.drawing import tours
from ovman.generation.scenes import survey
from ovman.generation.trials import Trials
from ovman.generation.verdict import verdict
from ovman.records.geometry import Spawn
from ovman.records.scene import Alteration
from ovman.records.task import Rejection, Relation
from ovman.records.trial import Candidate, Trial
from ovman.sim.session import Session
from tests.arms import CONFIG

SCENE, MUG = "FloorPlan301", "Mug|+02.82|+00.80|-01.22"
ON_A_BALL = Alteration(kind="displace", instance=MUG, placement=(0.201, -1.217), height_m=0.2994)
"""Put down on a basketball, the mug slides off and comes to rest on the floor beside it."""


def measured(visits) -> Trial:
    with Session(SCENE, CONFIG) as session:
        scene = survey(session, CONFIG.tour.waypoints, CONFIG.primitives.step_m)
        x, z = scene.waypoints[-1]
        candidate = Candidate(
            id=f"{SCENE}/moved/0000",
            scene=SCENE,
            relation=Relation.MOVED,
            category="Mug",
            target=MUG,
            distractor=None,
            tours=tours(scene, CONFIG.tour.headings, None),
            first=(),
            second=(ON_A_BALL,),
            others={},
            spawn=Spawn(x=x, z=z, yaw_deg=0.0),
            refused=None,
        )
        return Trials(session, scene, CONFIG, visits, "code").measure(candidate)


def test_what_slides_off_has_drifted_from_its_placement(tmp_path):
    trial = measured(tmp_path)
    drift_m = trial.measured.drift_m[MUG]
    assert CONFIG.admissibility.drift_tolerance_m < drift_m < CONFIG.admissibility.tau_m
    assert Rejection.DRIFTED in verdict(trial, CONFIG).reasons
