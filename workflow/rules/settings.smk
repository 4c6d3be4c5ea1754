# Settings, checked; what the rules derive from them; the ceiling on jobs that use the GPU.

import sys

sys.path.insert(0, str(workflow.basedir))

from ovman import config as ovman_config
from ovman.agents.arms import Kind, of_kind

try:
    settings = ovman_config.load(config)
except ovman_config.ConfigError as error:
    raise SystemExit(str(error))

SCENES = settings.benchmark.scenes
SEEDS = settings.evaluation.seeds
STATIC = [arm.name for arm in of_kind(Kind.STATIC)]
EMBODIED = [arm.name for arm in of_kind(Kind.EMBODIED)]
GPU = 1 if settings.benchmark.backend == "thor" else 0

# A user's --resources replaces that of the profile, so the ceiling is set here; ovman.sim.gpu holds a lock besides.
workflow.global_resources["gpu"] = type(workflow.global_resources["_cores"])("gpu", 1)


wildcard_constraints:
    scene=r"FloorPlan\d+",
    arm="[a-z_]+",
    seed=r"\d+",


def stage(name):
    """The one parameter of a stage's rule."""
    return ovman_config.canonical(settings, name)
