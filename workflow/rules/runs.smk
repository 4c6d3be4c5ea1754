rule runs:
    input:
        episodes="results/episodes/main.jsonl",
        executions=expand("results/executions/{arm}/seed{seed}/{scene}.jsonl", arm=EMBODIED, seed=SEEDS, scene=SCENES),
    output:
        expand("results/runs/{arm}/seed{seed}/{scene}.jsonl", arm=EMBODIED, seed=SEEDS, scene=SCENES),
    log:
        "logs/runs.log",
    params:
        constants=stage("runs"),
    script:
        "../scripts/runs.py"
