# The one map of both visits of each episode, for arms that do not tell visits apart.
rule maintained:
    input:
        episodes=[f"results/episodes/{split}.jsonl" for split in JOB_SPLITS],
        detections=expand("results/detections/{scene}.npz", scene=JOB_SCENES),
    output:
        maintained=expand("results/maintained/{scene}.npz", scene=JOB_SCENES),
    log:
        "logs/maintained.log",
    benchmark:
        "benchmarks/maintained.tsv"
    params:
        constants=stage("maintained"),
    script:
        "../scripts/maintained.py"


# Of a scene of splits that are no part of the main job.
use rule maintained as maintained_of_scene with:
    input:
        episodes=episodes_of_scene,
        detections="results/detections/{scene}.npz",
    output:
        maintained="results/maintained/{scene}.npz",
    log:
        "logs/maintained/{scene}.log",
    benchmark:
        "benchmarks/maintained/{scene}.tsv"
    wildcard_constraints:
        scene=OF_OTHER_SCENES,
