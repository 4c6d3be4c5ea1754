# DualMap as its authors released it, from a clone of the user's (packages/ovman-released/README.md). A missing part is no error: the
# rules leave empty records and say so in results/notes/released_dualmap.json, and the tables have a note in the place of its rows.

from pathlib import Path

from ovman_released.notes import forget_failure
from ovman_released.settings import released_dualmap

# Snakemake sees no weights and no GPU: what was missing may be there now.
if workflow.is_main_process:
    forget_failure(Path("results", "notes", "released_dualmap.json"))


rule released_dualmap_setup:
    input:
        episodes="results/episodes/main.jsonl",
    output:
        note="results/notes/released_dualmap.json",
    log:
        "logs/released_dualmap_setup.log",
    benchmark:
        "benchmarks/released_dualmap_setup.tsv"
    resources:
        gpu=int(released_dualmap(settings).device == "cuda"),
    params:
        constants=stage("released_dualmap_setup"),
    script:
        "../scripts/released_dualmap_setup.py"


# Finished runs are kept in results/journal/released_dualmap/{scene}/, with what DualMap said.
rule released_dualmap:
    input:
        note="results/notes/released_dualmap.json",
        scene="results/scenes/{scene}.json",
        episodes="results/episodes/main.jsonl",
        visits="results/visits/{scene}.json",
    output:
        maps="results/released_dualmap/maps/{scene}.npz",
        nouns="results/released_dualmap/nouns/{scene}.npz",
    log:
        "logs/released_dualmap/{scene}.log",
    benchmark:
        "benchmarks/released_dualmap/{scene}.tsv"
    resources:
        gpu=max(GPU, int(released_dualmap(settings).device == "cuda")),
    params:
        constants=stage("released_dualmap"),
    script:
        "../scripts/released_dualmap.py"


# The nouns are the same in every scene.
rule released_dualmap_predictions:
    input:
        note="results/notes/released_dualmap.json",
        episodes="results/episodes/main.jsonl",
        sightings=handed("results/episodes/sightings.jsonl"),
        dualmap=expand("results/released_dualmap/maps/{scene}.npz", scene=SCENES),
        nouns=f"results/released_dualmap/nouns/{SCENES[0]}.npz",
    output:
        predictions="results/predictions/{arm}.jsonl",
    log:
        "logs/predictions/{arm}.log",
    benchmark:
        "benchmarks/predictions/{arm}.tsv"
    wildcard_constraints:
        arm="|".join(arm.name for arm in ARMS if arm.made_by == "released_dualmap") or "none",
    params:
        constants=stage_of_arm("released_dualmap_predictions"),
    script:
        "../scripts/released_dualmap_predictions.py"
