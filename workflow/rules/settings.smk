# Settings, checked, and what the rules derive from them.

import functools
import sys

sys.path.insert(0, str(workflow.basedir))

from ovman.agents.arms import Kind, Source, named, of_kind
from ovman.config import ConfigError, canonical, load
from ovman.perception.weights import located
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
# And these, for networks.
NETWORK_GPU = int(settings.perception.device == "cuda")


wildcard_constraints:
    scene=r"FloorPlan\d+",
    arm="[a-z_]+",


def stage(name):
    """The one parameter of a stage's rule."""
    return canonical(settings, name)


def own(*files):
    """Inputs of an arm with positions of its own; one with positions handed over does not depend on what was perceived."""
    return lambda wildcards: (
        [file.format(**dict(wildcards.items())) for file in files] if named(wildcards.arm).positions is Source.OWN else []
    )


def weights(*names):
    """The files that settings of section perception name, as inputs; one that is not there is the job's to complain of."""
    files = [located(functools.reduce(getattr, name.split("."), settings.perception)) for name in names]
    return [str(file) for file in files if file is not None and file.is_file()]
