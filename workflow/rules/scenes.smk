rule scenes:
    output:
        "results/scenes/{scene}.json",
    log:
        "logs/scenes/{scene}.log",
    benchmark:
        "benchmarks/scenes/{scene}.tsv"
    resources:
        gpu=GPU,
    params:
        constants=stage("scenes"),
    script:
        "../scripts/scenes.py"
