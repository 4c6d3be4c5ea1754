# One job makes the maps of all scenes: clustering takes less time than starting a job.
rule maps:
    input:
        detections=expand("results/detections/{scene}.npz", scene=JOB_SCENES),
    output:
        maps=expand("results/maps/{scene}.npz", scene=JOB_SCENES),
    log:
        "logs/maps.log",
    benchmark:
        "benchmarks/maps.tsv"
    params:
        constants=stage("maps"),
    script:
        "../scripts/maps.py"


# Of a scene of splits that are no part of the main job.
use rule maps as maps_of_scene with:
    input:
        detections="results/detections/{scene}.npz",
    output:
        maps="results/maps/{scene}.npz",
    log:
        "logs/maps/{scene}.log",
    benchmark:
        "benchmarks/maps/{scene}.tsv"
    wildcard_constraints:
        scene=OF_OTHER_SCENES,
