# Settings, checked, and what the rules derive from them.

import sys

sys.path.insert(0, str(workflow.basedir))

from ovman.agents.arms import Kind, of_kind
from ovman.config import ConfigError, canonical, load
from ovman.workflow import prepare

prepare(workflow)
overlays = [path for path in workflow.configfiles if str(path) in map(str, workflow.overwrite_configfiles)]

try:
    settings = load(config, files=[os.path.join(workflow.basedir, "config.yaml"), *overlays])
except ConfigError as error:
    raise SystemExit(str(error))

SCENES = settings.benchmark.scenes
SEEDS = settings.evaluation.seeds
STATIC = [arm.name for arm in of_kind(Kind.STATIC)]
EMBODIED = [arm.name for arm in of_kind(Kind.EMBODIED)]
# Jobs that start a simulator ask for this many GPUs; there is one to be had (ovman.workflow), and a job holds it (ovman.job).
GPU = int(settings.benchmark.backend == "thor")


wildcard_constraints:
    scene=r"FloorPlan\d+",
    arm="[a-z_]+",


def stage(name):
    """The one parameter of a stage's rule."""
    return canonical(settings, name)
