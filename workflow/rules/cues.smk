# Colours and extents of what was detected, and what it truly shows. No arm reads them. One job, as for the maps.
rule cues:
    input:
        scenes=expand("results/scenes/{scene}.json", scene=JOB_SCENES),
        visits=expand("results/visits/{scene}.json", scene=JOB_SCENES),
        detections=expand("results/detections/{scene}.npz", scene=JOB_SCENES),
    output:
        cues=expand("results/cues/{scene}.npz", scene=JOB_SCENES),
    log:
        "logs/cues.log",
    benchmark:
        "benchmarks/cues.tsv"
    params:
        constants=stage("cues"),
    script:
        "../scripts/cues.py"


# Of a scene of splits that are no part of the main job.
use rule cues as cues_of_scene with:
    input:
        scenes="results/scenes/{scene}.json",
        visits="results/visits/{scene}.json",
        detections="results/detections/{scene}.npz",
    output:
        cues="results/cues/{scene}.npz",
    log:
        "logs/cues/{scene}.log",
    benchmark:
        "benchmarks/cues/{scene}.tsv"
    wildcard_constraints:
        scene=OF_OTHER_SCENES,
