rule scenes:
    output:
        scene="results/scenes/{scene}.json",
    log:
        "logs/scenes/{scene}.log",
    benchmark:
        "benchmarks/scenes/{scene}.tsv"
    retries: 2
    resources:
        gpu=GPU,
    params:
        constants=stage("scenes"),
    script:
        "../scripts/scenes.py"
