# One job judges an arm: judging a scene takes less time than starting a job.
rule scores:
    input:
        episodes="results/episodes/main.jsonl",
        rollouts=rollouts_of,
    output:
        scores=expand("results/scores/{{arm}}/seed{seed}/{scene}.jsonl", seed=SEEDS, scene=SCENES),
    log:
        "logs/scores/{arm}.log",
    benchmark:
        "benchmarks/scores/{arm}.tsv"
    params:
        constants=stage_of_arm("scores"),
    script:
        "../scripts/scores.py"
