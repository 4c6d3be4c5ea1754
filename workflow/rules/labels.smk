# What the detections truly show, for arms that are handed their grounding over their own maps. One job, as for the maps.
rule labels:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=JOB_SCENES),
        visits=expand("results/visits/{scene}.json", scene=JOB_SCENES),
        detections=expand("results/detections/{scene}.npz", scene=JOB_SCENES),
    output:
        labels=expand("results/labels/{scene}.npz", scene=JOB_SCENES),
    log:
        "logs/labels.log",
    benchmark:
        "benchmarks/labels.tsv"
    params:
        constants=stage("labels"),
    script:
        "../scripts/labels.py"


# Of a scene of splits that are no part of the main job.
use rule labels as labels_of_scene with:
    input:
        scenes="results/scenes/{scene}.json",
        visits="results/visits/{scene}.json",
        detections="results/detections/{scene}.npz",
    output:
        labels="results/labels/{scene}.npz",
    log:
        "logs/labels/{scene}.log",
    benchmark:
        "benchmarks/labels/{scene}.tsv"
    wildcard_constraints:
        scene=OF_OTHER_SCENES,
