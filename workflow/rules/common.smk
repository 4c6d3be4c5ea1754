# Settings, checked, and what the rules derive from them.

import functools

from ovman.analysis import registry
from ovman.settings import (
    Kind,
    Need,
    Withheld,
    named,
    of_kind,
    arms_of,
)
from ovman.records.episode import VARIANTS
from ovman.workflow.batches import batches
from ovman.settings.config import ConfigError, load
from ovman.workflow.fork_server import ForkServer
from ovman.workflow.parameter import canonical
from ovman.settings.plugins import plugins_of
from ovman.perception.weights import is_graph, located, phrases_of
from ovman.workflow.snakefile import check_agents, prepare, print_deaths
from ovman.workflow.snakemake_internals import fork_scripts, go_before, group_like, lift_rate_limit, overlays

prepare(workflow)
fork_scripts(workflow, ForkServer().run)

try:
    files = [*CONFIG_FILES, *overlays(workflow)]
    settings = load(config, files)
    if workflow.is_main_process:
        check_agents(settings, files)
except ConfigError as error:
    raise SystemExit(str(error))

# The splits, main first, and their scenes.
SPLITS = tuple(settings.splits)
SCENES_OF = {name: split.scenes for name, split in settings.splits.items()}
SCENES = SCENES_OF["main"]
# The splits of results/all, and those of results/tables: the paper's, whose tours are like those of split main.
JOB_SPLITS = [name for name, split in settings.splits.items() if split.in_main_job]
PAPER_SPLITS = [name for name in JOB_SPLITS if settings.splits[name].plain]
# The scenes of the main job, and those of other splits.
JOB_SCENES = tuple(dict.fromkeys(scene for name in JOB_SPLITS for scene in SCENES_OF[name]))
OTHER_SCENES = sorted({scene for scenes in SCENES_OF.values() for scene in scenes} - {*JOB_SCENES})
SEEDS = settings.evaluation.seeds
ARMS = arms_of(settings.arms)
STATIC = [arm.name for arm in of_kind(ARMS, Kind.STATIC)]
EMBODIED = [arm.name for arm in of_kind(ARMS, Kind.EMBODIED)]
# The splits whose files bear the name of a split.
FURTHER = [name for name in SPLITS if name != "main"]
OF_OTHER_SCENES = "|".join(OTHER_SCENES) or "none"
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
    split="|".join(FURTHER) or "none",
    of=f"(({'|'.join(FURTHER)})/)?" if FURTHER else "()",


def stage(name):
    """The one parameter of a stage's rule."""
    return canonical(settings, name)


def stage_of_arm(name):
    """The one parameter of a stage's rule whose jobs are each of one arm."""
    return lambda wildcards: canonical(settings, name, wildcards.arm)


def needed(what, *files):
    """Inputs of an arm that needs one of these; others do not depend on them. A file of a scene is that of the job's scene, or those
    of all scenes of the split that it answers."""

    def found(wildcards):
        needs = set(named(ARMS, wildcards.arm).needs) & {Need(one) for one in what}
        of_scenes = {"scene": SCENES_OF[split_answered(wildcards)]} | dict(wildcards.items())
        return [one for file in files for one in expand(file, **of_scenes)] if needs else []

    return found


def handed(file):
    """An input of the arms that are given what the tours truly recorded: a file, or a function of the wildcards."""

    def found(wildcards):
        if not named(ARMS, wildcards.arm).reads_sightings:
            return []
        return [file(wildcards) if callable(file) else file]

    return found


def with_episodes(files):
    """Inputs that are known once the episodes are: Snakemake then compares them, and plans nothing that follows equal episodes."""

    def found(wildcards):
        checkpoints.episodes.get()
        for split in JOB_SPLITS[1:]:
            checkpoints.split_episodes.get(split=split)
        if hasattr(wildcards, "split"):
            checkpoints.split_episodes.get(split=wildcards.split)
        checkpoints.readmitted.get()
        return files(wildcards) if callable(files) else files

    return found


def split_answered(wildcards):
    """The split whose episodes are answered: wildcard `of` is empty for the benchmark's own."""
    return wildcards.of[:-1] or SPLITS[0]


def episodes_answered(wildcards):
    """The episodes that a prediction job answers."""
    return f"results/episodes/{split_answered(wildcards)}.jsonl"


def sightings_answered(wildcards):
    """What the tours of these episodes truly recorded."""
    split = split_answered(wildcards)
    return "results/episodes/" + ("" if split == SPLITS[0] else f"{split}_") + "sightings.jsonl"


def executed_answers(wildcards):
    """The predictions of the arm that an embodied one executes, where each is one answer and the split asks that arm."""
    executed = settings.arms.get(named(ARMS, wildcards.arm).executes)
    split = split_answered(wildcards)
    asked = executed is not None and (split == SPLITS[0] or executed.name in settings.splits[split].arms)
    if not asked or executed.made_by is not None or not executed.answers_once:
        return []
    return [f"results/predictions/{wildcards.of}{executed.name}.jsonl"]


def arms_of_split(split, kind):
    """The arms of a kind that a split names; what names an arm that is not there is left out."""
    return [name for name in settings.splits[split].arms if name in settings.arms and settings.arms[name].kind is kind]


def metrics_across(splits):
    """The rates and outcomes of the arms of both kinds on each split."""
    names = [f"{kind.value}_{what}" for kind in Kind for what in ("rates", "outcomes")]
    return expand("results/metrics/{split}/{name}.csv", split=splits, name=names)


def scenes_of_split(wildcards):
    """The floor plans of a split."""
    return SCENES_OF[wildcards.split]


def predictions_of_split(wildcards):
    """The predictions of the static arms of a split."""
    arms = arms_of_split(wildcards.split, Kind.STATIC)
    return expand("results/predictions/{split}/{arm}.jsonl", split=wildcards.split, arm=arms)


def scores_of_split(wildcards):
    """The judged runs of the embodied arms of a split."""
    arms = arms_of_split(wildcards.split, Kind.EMBODIED)
    return expand("results/scores/{split}/{arm}.jsonl", split=wildcards.split, arm=arms)


def metrics_of_split(wildcards):
    """The metrics that the tables of a split show."""
    return expand("results/metrics/{name}.csv", name=registry.split_tables(settings, wildcards.split))


def of_split_scenes(file):
    """A file of each scene of the split that a job is of; the benchmark's own where it has no wildcard of a split."""
    return lambda wildcards: expand(file, scene=SCENES_OF[dict(wildcards.items()).get("split", SPLITS[0])])


def episodes_of_scene(wildcards):
    """The episodes of the splits that have a scene."""
    return [f"results/episodes/{split}.jsonl" for split in SPLITS if wildcards.scene in SCENES_OF[split]]


def labels_of_map(wildcards):
    """What the detections of the arm's map truly show, for an arm that is given its grounding by them."""
    arm = named(ARMS, wildcards.arm)
    if not arm.reads_labels:
        return []
    file = "results/walk_labels/{scene}.npz" if Need.DUALMAP in arm.needs else "results/labels/{scene}.npz"
    return expand(file, scene=SCENES_OF[split_answered(wildcards)])


def scenes_named(wildcards):
    """What is in the scenes, for an arm that is told the noun of another thing in them."""
    if named(ARMS, wildcards.arm).withheld is not Withheld.NOUN_WRONG:
        return []
    return expand("results/scenes/{scene}.json", scene=SCENES_OF[split_answered(wildcards)])


def rollouts_of(wildcards):
    """An arm's own rollouts, or those of the arm whose runs it cuts."""
    arm = named(ARMS, wildcards.arm).cut_from or wildcards.arm
    split = dict(wildcards.items()).get("split", SPLITS[0])
    of = "" if split == SPLITS[0] else f"{split}/"
    return expand("results/rollouts/{of}{arm}/seed{seed}/{scene}.jsonl", of=of, arm=arm, seed=SEEDS, scene=SCENES_OF[split])


def network_gpu(wildcards):
    """How many GPUs the networks of an arm ask for."""
    return NETWORK_GPU if Need.NETWORKS in named(ARMS, wildcards.arm).needs else 0


def weights(*names):
    """The files that settings of section perception name, as inputs; the job reports a missing one.

    Beside the graph of an image tower lie the phrases. A graph needs no description of its towers.
    """
    graph = is_graph(settings.perception.encoder.weights)
    names = [name for name in names if not (graph and name == "encoder.model")]
    files = [located(functools.reduce(getattr, name.split("."), settings.perception)) for name in names]
    files += [phrases_of(file) for name, file in zip(names, files) if graph and name == "encoder.weights"]
    return [str(file) for file in files if file is not None and file.is_file()]


def driven_with(scenes):
    """The inputs of a job of these scenes."""
    return {
        "episodes": episodes_answered,
        "sightings": handed(sightings_answered),
        "predictions": executed_answers,
        "visits": needed(["tours", "maps", "detections", "segments"], *expand("results/visits/{scene}.json", scene=scenes)),
        "maps": needed(["maps"], *expand("results/maps/{scene}.npz", scene=scenes)),
        "dualmap": needed(["dualmap"], *expand("results/dualmap/{scene}.npz", scene=scenes)),
        "detections": needed(["detections"], *expand("results/detections/{scene}.npz", scene=scenes)),
        "segments": needed(["segments"], *expand("results/segments/{scene}.npz", scene=scenes)),
        "nouns": needed(["maps", "dualmap", "detections", "segments"], "results/nouns.npz"),
        "networks": needed(["networks"], *weights("detector.weights", "encoder.weights", "encoder.model")),
    }


def driven(scenes):
    """The outputs of a job of these scenes, by seed."""
    return {f"seed{seed}": [f"results/rollouts/{{of}}{{arm}}/seed{seed}/{scene}.jsonl" for scene in scenes] for seed in SEEDS}
