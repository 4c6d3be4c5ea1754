# Settings, checked, and what the rules derive from them.

import functools
import sys

sys.path.insert(0, str(workflow.basedir))

from ovman.analysis.registry import compared, in_tables, of_stage
from ovman.models.settings import Kind, Need, named, of_kind, arms_of
from ovman.workflow.config import ConfigError, load
from ovman.workflow.parameter import canonical
from ovman.workflow.plugins import plugins_of
from ovman.perception.weights import located
from ovman.workflow.snakefile import check_agents, prepare, print_deaths
from ovman.workflow.snakemake_internals import lift_rate_limit, overlays

prepare(workflow)

try:
    files = [os.path.join(workflow.basedir, "config.yaml"), *overlays(workflow)]
    settings = load(config, files)
    if workflow.is_main_process:
        check_agents(settings, files)
except ConfigError as error:
    raise SystemExit(str(error))

SCENES = settings.benchmark.scenes
SEEDS = settings.evaluation.seeds
ARMS = arms_of(settings.arms)
STATIC = [arm.name for arm in of_kind(ARMS, Kind.STATIC)]
EMBODIED = [arm.name for arm in of_kind(ARMS, Kind.EMBODIED)]
PLUGINS = plugins_of(settings)
# The rules `predictions` and `rollouts` make the records of these arms; rules of plug-ins make the others'.
OF_NO_PLUGIN = "|".join(arm.name for arm in ARMS if arm.made_by is None) or "none"
# GPUs that a job with a simulator asks for. There is one (ovman.workflow.snakemake_internals); a job locks it (ovman.workflow.job).
GPU = int(settings.benchmark.backend == "thor")
# GPUs that a job with networks asks for.
NETWORK_GPU = int(settings.perception.device == "cuda")


wildcard_constraints:
    scene=r"FloorPlan\d+",
    arm="[a-z][a-z0-9_]*",


def stage(name):
    """The one parameter of a stage's rule."""
    return canonical(settings, name)


def stage_of_arm(name):
    """The one parameter of a stage's rule whose jobs are each of one arm."""
    return lambda wildcards: canonical(settings, name, wildcards.arm)


def needed(what, *files):
    """Inputs of an arm that needs one of these; others do not depend on them."""

    def found(wildcards):
        needs = set(named(ARMS, wildcards.arm).needs) & {Need(one) for one in what}
        return [file.format(**dict(wildcards.items())) for file in files] if needs else []

    return found


def handed(file):
    """An input of the arms that are given what the tours truly recorded."""

    def found(wildcards):
        return [file] if named(ARMS, wildcards.arm).reads_sightings else []

    return found


def rollouts_of(wildcards):
    """An arm's own rollouts, or those of the arm whose runs it cuts."""
    arm = named(ARMS, wildcards.arm).cut_from or wildcards.arm
    return expand("results/rollouts/{arm}/seed{seed}/{scene}.jsonl", arm=arm, seed=SEEDS, scene=SCENES)


def network_gpu(wildcards):
    """How many GPUs the networks of an arm ask for."""
    return NETWORK_GPU if Need.NETWORKS in named(ARMS, wildcards.arm).needs else 0


def weights(*names):
    """The files that settings of section perception name, as inputs; the job reports a missing one."""
    files = [located(functools.reduce(getattr, name.split("."), settings.perception)) for name in names]
    return [str(file) for file in files if file is not None and file.is_file()]
