# Whether an arm answers from DualMap's maps, of which there are metrics then.
OF_DUALMAP = any(Need.DUALMAP in arm.needs for arm in ARMS)


rule metrics:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=expand("results/predictions/{arm}.jsonl", arm=STATIC),
        runs=expand("results/runs/{arm}/seed{seed}/{scene}.jsonl", arm=EMBODIED, seed=SEEDS, scene=SCENES),
    output:
        static_outcomes="results/metrics/static_outcomes.csv",
        embodied_outcomes="results/metrics/embodied_outcomes.csv",
        static_rates="results/metrics/static_rates.csv",
        embodied_rates="results/metrics/embodied_rates.csv",
        taxonomy="results/metrics/taxonomy.csv",
        significance="results/metrics/significance.csv",
        navigation="results/metrics/navigation.csv",
        difficulty="results/metrics/difficulty.csv",
        budget="results/metrics/budget.csv",
        pairings="results/metrics/pairings.csv",
        own_task="results/metrics/own_task.csv",
        seeds="results/metrics/seeds.csv",
        scenes="results/metrics/scenes.csv",
    log:
        "logs/metrics.log",
    benchmark:
        "benchmarks/metrics.tsv"
    params:
        constants=stage("metrics"),
    script:
        "../scripts/metrics.py"
