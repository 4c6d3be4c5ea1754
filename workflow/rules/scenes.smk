rule scenes:
    output:
        scene="results/scenes/{scene}.json",
    log:
        "logs/scenes/{scene}.log",
    benchmark:
        "benchmarks/scenes/{scene}.tsv"
    resources:
        gpu=GPU,
    retries: 2
    params:
        constants=canonical(CONFIG, "scenes"),
    script:
        "../scripts/scenes.py"
