# One job makes the maps of all scenes: clustering takes less time than starting a job.
rule maps:
    input:
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
    output:
        maps=expand("results/maps/{scene}.npz", scene=SCENES),
    log:
        "logs/maps.log",
    benchmark:
        "benchmarks/maps.tsv"
    params:
        constants=stage("maps"),
    script:
        "../scripts/maps.py"
