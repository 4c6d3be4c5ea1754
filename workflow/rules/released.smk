# The baselines as their authors released them, from clones of the user's (docs/baselines.md). What is missing for one is no error: its
# rule leaves empty records and says so in results/released/{system}.json, and the tables have a note in the place of its rows.

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
    retries: 2
    resources:
        gpu=max(GPU, int(settings.released.cow.device == "cuda")),
    params:
        constants=stage("released_cow"),
    script:
        "../scripts/released_cow.py"


ruleorder: released_cow > executions
