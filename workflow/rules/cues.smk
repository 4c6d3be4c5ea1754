# Colours and extents of what was detected, and what it truly shows. No arm reads them. One job, as for the maps.
rule cues:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=SCENES),
        visits=expand("results/visits/{scene}.json", scene=SCENES),
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
    output:
        cues=expand("results/cues/{scene}.npz", scene=SCENES),
    log:
        "logs/cues.log",
    benchmark:
        "benchmarks/cues.tsv"
    params:
        constants=stage("cues"),
    script:
        "../scripts/cues.py"
