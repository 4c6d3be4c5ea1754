# One job judges an arm: judging a scene takes less time than starting a job.
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
