# `ancient`: a simulator that passed its check once is not checked again when the check changes.
rule scenes:
    input:
        simulator=[ancient("results/simulator.txt")] if GPU else [],
    output:
        scene="results/scenes/{scene}.json",
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
