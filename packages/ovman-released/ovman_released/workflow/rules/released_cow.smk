# CoW as its authors released it, from a clone of the user's (packages/ovman-released/README.md). A missing part is no error: the rule
# leaves empty records and says so in results/notes/released_cow.json, and the tables have a note in the place of its rows.

from ovman_released.notes import forget_failure
from ovman_released.settings import released_cow

# Snakemake sees no weights and no GPU: what was missing may be there now.
if workflow.is_main_process:
    forget_failure(Path("results", "notes", "released_cow.json"))


# The released agent carries state from one episode to the next, so one job has all episodes in their order, and all seeds.
rule released_cow:
    input:
        episodes="results/episodes/main.jsonl",
    output:
        rollouts="results/rollouts/main/cow_released.jsonl",
        note="results/notes/released_cow.json",
    log:
        "logs/released_cow.log",
    resources:
        gpu=max(GPU, int(released_cow(settings).device == "cuda")),
    params:
        seeds=settings.evaluation.seeds,
        constants=pick("released_cow"),
        plugins=settings.plugins,
        code=digest_code("ovman_released.cow"),
        scripts=SCRIPTS,
    script:
        "../scripts/released.py"
