rule metrics:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=expand("results/predictions/{arm}.jsonl", arm=STATIC),
        runs=expand("results/runs/{arm}/seed{seed}/{scene}.jsonl", arm=EMBODIED, seed=SEEDS, scene=SCENES),
    output:
        "results/metrics/static_outcomes.csv",
        "results/metrics/embodied_outcomes.csv",
        static="results/metrics/static_rates.csv",
        embodied="results/metrics/embodied_rates.csv",
    log:
        "logs/metrics.log",
    params:
        constants=stage("metrics"),
    script:
        "../scripts/metrics.py"
