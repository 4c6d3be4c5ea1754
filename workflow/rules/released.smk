# The baselines as their authors released them, from clones of the user's (docs/baselines.md). What is missing for one is no error: its
# rule leaves empty records and says so in results/released/{system}.json, and the tables have a note in the place of its rows.

from pathlib import Path

from ovman_released.status import forget_failures

# Snakemake sees no weights and no GPU: what was missing may be there now.
if workflow.is_main_process:
    forget_failures(Path("results", "released"))

# Systems of which the settings name a clone.
RELEASED = list(dict.fromkeys(arm.released for arm in ARMS if arm.released is not None))


# The released agent carries state from one episode to the next, so one job has all episodes in their order, and all seeds.
rule released_cow:
    input:
        episodes="results/episodes/main.jsonl",
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
    output:
        executions=expand("results/executions/cow_released/seed{seed}/{scene}.jsonl", seed=SEEDS, scene=SCENES),
        status="results/released/cow.json",
    log:
        "logs/released_cow.log",
    benchmark:
        "benchmarks/released_cow.tsv"
    resources:
        gpu=max(GPU, int(settings.released.cow.device == "cuda")),
    params:
        constants=stage("released_cow"),
    script:
        "../scripts/released_cow.py"


ruleorder: released_cow > executions


rule released_dualmap_setup:
    input:
        episodes="results/episodes/main.jsonl",
    output:
        status="results/released/dualmap.json",
    log:
        "logs/released_dualmap_setup.log",
    benchmark:
        "benchmarks/released_dualmap_setup.tsv"
    resources:
        gpu=int(settings.released.dualmap.device == "cuda"),
    params:
        constants=stage("released_dualmap_setup"),
    script:
        "../scripts/released_dualmap_setup.py"


# Finished runs are kept in results/journal/released_dualmap/{scene}/, with what DualMap said.
rule released_dualmap:
    input:
        status="results/released/dualmap.json",
        scene="results/scenes/{scene}.json",
        episodes="results/episodes/main.jsonl",
        trials="results/trials/{scene}.jsonl",
    output:
        maps="results/released/dualmap/maps/{scene}.npz",
        nouns="results/released/dualmap/nouns/{scene}.npz",
    log:
        "logs/released_dualmap/{scene}.log",
    benchmark:
        "benchmarks/released_dualmap/{scene}.tsv"
    resources:
        gpu=max(GPU, int(settings.released.dualmap.device == "cuda")),
    params:
        constants=stage("released_dualmap"),
    script:
        "../scripts/released_dualmap.py"


# The nouns are the same in every scene.
rule released_dualmap_predictions:
    input:
        status="results/released/dualmap.json",
        episodes="results/episodes/main.jsonl",
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
        dualmap=expand("results/released/dualmap/maps/{scene}.npz", scene=SCENES),
        nouns=f"results/released/dualmap/nouns/{SCENES[0]}.npz",
    output:
        predictions="results/predictions/{arm}.jsonl",
    log:
        "logs/predictions/{arm}.log",
    benchmark:
        "benchmarks/predictions/{arm}.tsv"
    wildcard_constraints:
        arm="|".join(arm.name for arm in ARMS if arm.released == "dualmap") or "none",
    params:
        constants=stage_of_arm("released_dualmap_predictions"),
    script:
        "../scripts/released_dualmap_predictions.py"


ruleorder: released_dualmap_predictions > predictions
