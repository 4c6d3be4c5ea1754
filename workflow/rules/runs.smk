# One job judges an arm: judging a scene takes less time than starting a job.


def executed(wildcards):
    """An arm's own executions, or those of the arm whose runs it cuts."""
    arm = named(ARMS, wildcards.arm).cut_from or wildcards.arm
    return expand("results/executions/{arm}/seed{seed}/{scene}.jsonl", arm=arm, seed=SEEDS, scene=SCENES)


rule runs:
    input:
        episodes="results/episodes/main.jsonl",
        executions=executed,
    output:
        runs=expand("results/runs/{{arm}}/seed{seed}/{scene}.jsonl", seed=SEEDS, scene=SCENES),
    log:
        "logs/runs/{arm}.log",
    benchmark:
        "benchmarks/runs/{arm}.tsv"
    params:
        constants=stage_of_arm("runs"),
    script:
        "../scripts/runs.py"
