rule dualmap:
    input:
        walks="results/walks/{scene}.npz",
        episodes="results/episodes/main.jsonl",
    output:
        dualmap="results/dualmap/{scene}.npz",
    log:
        "logs/dualmap/{scene}.log",
    benchmark:
        "benchmarks/dualmap/{scene}.tsv"
    params:
        constants=stage("dualmap"),
    script:
        "../scripts/dualmap.py"


rule dualmap_objects:
    input:
        dualmap=expand("results/dualmap/{scene}.npz", scene=SCENES),
    output:
        objects="results/metrics/dualmap.csv",
    log:
        "logs/dualmap_objects.log",
    benchmark:
        "benchmarks/dualmap_objects.tsv"
    params:
        constants=stage("dualmap_objects"),
    script:
        "../scripts/dualmap_objects.py"
