# DualMap as its authors released it, from a clone of the user's (packages/ovman-released/README.md). A missing part is no error: the
# rules leave empty records and say so in results/notes/released_dualmap.json, and the tables have a note in the place of its rows.

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
    resources:
        gpu=int(released_dualmap(settings).device == "cuda"),
    params:
        constants=pick(*(f"released_dualmap.{name}" for name in ("root", "commit", "python", "device"))),
        plugins=settings.plugins,
        code=digest_code("ovman_released.dualmap_setup"),
        scripts=SCRIPTS,
    script:
        "../scripts/released.py"


rule released_dualmap:
    input:
        note="results/notes/released_dualmap.json",
        scenes="results/scenes/main.jsonl",
        episodes="results/episodes/main.jsonl",
        visits="results/visits/main.jsonl",
    output:
        maps=directory("results/released_dualmap/maps"),
        nouns="results/released_dualmap/nouns.npz",
    log:
        "logs/released_dualmap.log",
    resources:
        gpu=max(GPU, int(released_dualmap(settings).device == "cuda")),
    params:
        constants=pick("dualmap.runs", "dualmap.walk.turn_deg", "released_dualmap"),
        plugins=settings.plugins,
        code=digest_code("ovman_released.dualmap"),
        scripts=SCRIPTS,
    script:
        "../scripts/released.py"


rule released_dualmap_predictions:
    input:
        note="results/notes/released_dualmap.json",
        episodes="results/episodes/main.jsonl",
        sightings=if_arm(reads_sightings, "results/sightings/main.jsonl"),
        dualmap="results/released_dualmap/maps",
        nouns="results/released_dualmap/nouns.npz",
    output:
        predictions="results/predictions/main/{arm}.jsonl",
    log:
        "logs/predictions/main/{arm}.log",
    wildcard_constraints:
        arm="|".join(name for name, arm in ARMS.items() if arm.made_by == "released_dualmap") or "none",
    params:
        arm=entry_of_arm,
        constants=pick_of_arm("admissibility.min_mask_px"),
        plugins=settings.plugins,
        code=code_of_arm("ovman.evaluation.predictions"),
        scripts=SCRIPTS,
    script:
        "../scripts/released.py"
