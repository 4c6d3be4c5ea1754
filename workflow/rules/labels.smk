# What the detections truly show, for arms that are handed their grounding over their own maps. One job, as for the maps.
rule labels:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        visits=expand("results/visits/{scene}.json", scene=SCENES),
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
    output:
        labels=expand("results/labels/{scene}.npz", scene=SCENES),
    log:
        "logs/labels.log",
    benchmark:
        "benchmarks/labels.tsv"
    params:
        constants=stage("labels"),
    script:
        "../scripts/labels.py"
