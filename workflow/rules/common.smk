# Settings, checked, and what the rules derive from them.

import fcntl
import re
import sys
from pathlib import Path

# Of the repository, whether its Snakefile or workflow/Snakefile is run.
ROOT = next(
    one for one in (str(workflow.basedir), os.path.dirname(workflow.basedir)) if os.path.isdir(os.path.join(one, "ovman"))
)
# This checkout's code, whichever ovman the environment has installed, and `training/`; jobs import the same.
CODE_PATHS = [ROOT, os.path.join(ROOT, "packages", "ovman-engine")]
sys.path[:0] = CODE_PATHS
OVERLAYS = [os.path.abspath(path) for path in workflow.overwrite_configfiles]
# An agent may lie next to the overlay that names it.
AGENT_PATHS = list(dict.fromkeys(map(os.path.dirname, OVERLAYS)))
sys.path.extend(AGENT_PATHS)
os.environ["PYTHONPATH"] = os.pathsep.join([*CODE_PATHS, *filter(None, [os.environ.get("PYTHONPATH")])])
os.environ["OVMAN_AGENTS"] = os.pathsep.join(AGENT_PATHS)

# One Snakemake per directory. The kernel releases the lock however the process ends; Snakemake's own locks outlive a killed one.
if workflow.is_main_process and not workflow.dryrun:
    os.makedirs(".snakemake", exist_ok=True)
    LOCK = open(os.path.join(".snakemake", "ovman.lock"), "a")
    try:
        fcntl.flock(LOCK, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        raise SystemExit(f"{os.getcwd()}: another Snakemake works in this directory; wait for it, or stop it")

# Before anything imports NumPy: the same kernels, and so the same digits, on every processor.
import ovman.kernels

ovman.kernels.hold()

from ovman.perception.weights import is_graph, located, texts_of
from ovman.provenance import digest_code
from ovman.settings import Kind, Need
from ovman.settings.benchmark import HOUSE_NAME, HOUSES
from ovman.settings.config import ConfigError, file_with, load_files
from ovman.settings.plugins import plugins_of
from ovman.settings.settings import matching
from ovman.settings.settings_files import with_parts
from ovman.shipped import EMBEDDED, HOME
from ovman.settings.settings import job_of_arm, own_constants

CONFIG = with_parts(Path(ROOT, "config.yaml"))

if workflow.config_settings.config:
    raise SystemExit("--config: settings are not given on the command line; give changes as a file (--configfile)")


report: "../report/workflow.rst"


try:
    settings = load_files([CONFIG[0], *OVERLAYS])
except ConfigError as error:
    raise SystemExit(str(error))

CONSTANTS = settings.constants()
for name, arm in settings.arms.items():
    try:
        digest_code(arm.agent.partition(":")[0])
    except (ModuleNotFoundError, SyntaxError) as error:
        wrong = f"{os.path.basename(error.filename)}, line {error.lineno}: {error.msg}" if error.args[1:] else error
        where = file_with([*CONFIG, *OVERLAYS], ("arms", name, "agent"))
        raise SystemExit(
            f"{where}: arms.{name}.agent is {arm.agent!r}: {wrong}; install the module, put it next to the overlay, or mend it"
        )
ARMS = settings.arms
SPLITS = settings.splits
# The splits of results/all, and those of results/tables: the paper's.
JOB_SPLITS = [name for name, split in SPLITS.items() if split.in_main_job]
PAPER_SPLITS = [name for name in JOB_SPLITS if SPLITS[name].plain]
PLUGINS = plugins_of(settings)
# For scripts of plug-ins, which import `stage` from here.
SCRIPTS = os.path.join(ROOT, "workflow", "scripts")
# The rules `predictions` and `rollouts` make the records of these arms; rules of plug-ins make the others'.
OF_NO_PLUGIN = "|".join(name for name, arm in ARMS.items() if arm.made_by is None) or "none"
# Processes that a job may use. Two jobs side by side leave no core idle while the last scenes of one are worked on, and no job of all
# cores waits for one of a few.
HALF = max(1, (workflow.cores or 1) // 2)
# What looks at tours, for the cache that several rules share.
SIGHT = digest_code("ovman.perception.detections")
# Of all code, which takes a second to read: only restored work items are bound to it.
os.environ["OVMAN_CODE"] = digest_code() if os.path.isdir("results/cache/certified/restored") else ""
# GPUs that a job with a simulator, and one with networks, asks for. Jobs with a GPU run one at a time (profiles/default).
GPU = int(settings.benchmark.backend == "thor")
NETWORK_GPU = int(settings.perception.device == "cuda")


wildcard_constraints:
    arm="[a-z][a-z0-9_]*",
    split="|".join(SPLITS),


def pick(*names):
    """Return constants by dotted name, those of whole sections included: a rule reruns if one of its constants changes."""
    patterns = [name for one in names for name in (one, f"{one}.*")]
    return {name: CONSTANTS[name] for name in matching(patterns, CONSTANTS)}


def arms_involved(wildcards):
    """Return the arm of a job, and the arm whose answers it executes."""
    arm = ARMS[wildcards.arm]
    return [arm] if arm.executes is None else [arm, ARMS[arm.executes]]


def pick_of_arm(*names):
    """Return constants as `pick`, with those that the job's arm names in its entry."""
    return lambda wildcards: pick(*names, *(name for arm in arms_involved(wildcards) for name in own_constants(arm)))


def code_of_arm(module):
    """Return the digest of a module with that of the job's agent."""
    return lambda wildcards: digest_code(module, *(arm.agent.partition(":")[0] for arm in arms_involved(wildcards)))


def entry_of_arm(wildcards):
    """Return the entry of the job's arm without the words that only tables show."""
    return job_of_arm(settings, wildcards.arm)


def needs(*things):
    """Return whether an arm needs one of these."""
    return lambda arm: bool({Need(one) for one in things} & set(arm.needs))


def if_arm(condition, *files):
    """Return inputs of the arms that meet a condition; others do not depend on them."""
    return lambda wildcards: (expand(files, **dict(wildcards.items())) if condition(ARMS[wildcards.arm]) else [])


def reads_sightings(arm):
    """Return whether an arm is given the true positions of instances."""
    return arm.reads_sightings


def reads_scenes(arm):
    """Return whether an arm is given the untouched scene, or the noun of another thing in it."""
    return arm.reads_scenes


def embeds_phrases(arm):
    """Return whether an arm is given networks, or phrases that the encoder embeds."""
    return arm.embeds_phrases


def labels_of_map(wildcards):
    """Return the labels of the arm's map, for an arm with oracle grounding over its own map."""
    arm = ARMS[wildcards.arm]
    if not arm.reads_labels:
        return []
    return f"results/{'walk_labels' if Need.DUALMAP in arm.needs else 'labels'}/{wildcards.split}"


def executed_predictions(wildcards):
    """Return the predictions of the arm that an embodied arm executes, if that arm answers once and the split asks it."""
    name = ARMS[wildcards.arm].executes
    if name is None or name not in arms_of(wildcards.split) or ARMS[name].made_by or not ARMS[name].answers_once:
        return []
    return f"results/predictions/{wildcards.split}/{name}.jsonl"


def network_gpu(wildcards):
    """Return how many GPUs the networks of an arm ask for."""
    return NETWORK_GPU if ARMS[wildcards.arm].embeds_phrases else 0


def arms_of(split, kind=None):
    """Return the names of a split's arms, of one kind if it is given. Names of arms that do not exist are left out."""
    return [name for name in SPLITS[split].arms if name in ARMS and kind in (None, ARMS[name].kind)]


def predictions_of(split):
    """Return the predictions of a split's static arms."""
    return expand("results/predictions/{split}/{arm}.jsonl", split=split, arm=arms_of(split, Kind.STATIC))


def rollouts_of(wildcards):
    """Return the rollouts of a split's embodied arms. An arm with a smaller budget has those of the arm that it is cut from."""
    names = [ARMS[name].cut_from or name for name in arms_of(wildcards.split, Kind.EMBODIED)]
    return expand("results/rollouts/{split}/{arm}.jsonl", split=wildcards.split, arm=dict.fromkeys(names))


def with_episodes(files, splits=JOB_SPLITS):
    """Return inputs that are known once the episodes of splits are: Snakemake plans nothing that follows equal episodes."""

    def found(wildcards):
        for split in dict.fromkeys([*splits, *dict(wildcards.items()).get("split", "").split()]):
            checkpoints.episodes.get(split=split)
        checkpoints.readmitted.get()
        return files(wildcards) if callable(files) else files

    return found


def scenes_of(wildcards):
    """Return the scenes of the job's split; for homes, how they are drawn."""
    split = SPLITS[wildcards.split]
    return list(split.scenes) if split.homes is None else split.homes.model_dump()


def houses_of(wildcards):
    """Return the files of the houses among the scenes of the job's split."""
    names = (re.fullmatch(HOUSE_NAME, scene) for scene in SPLITS[wildcards.split].scenes)
    return [str(HOUSES / f"{found[1]}.json") for found in names if found]


def pick_of_split(fields, *names):
    """Return constants as `pick`, with these fields of the entry of the job's split."""
    return lambda wildcards: pick(*names, *(f"splits.{wildcards.split}.{field}" for field in fields))


def weights(*names):
    """Return the files that settings of section `perception` name; the job reports a missing one.

    The text tower lies next to the graph of an image tower. A graph needs no description of its towers.
    """
    graph = is_graph(settings.perception.encoder.weights)
    values = {name: CONSTANTS[f"perception.{name}"] for name in names if not (graph and name == "encoder.model")}
    files = [located(value) for value in values.values()]
    if graph and "encoder.weights" in values:
        files.append(texts_of(located(values["encoder.weights"])))
    return [str(file) for file in files if file is not None and file.is_file()]
