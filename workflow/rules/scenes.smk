# A simulator that was found well once is not looked at again when its check changes.
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
