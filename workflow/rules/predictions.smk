rule predictions:
    input:
        episodes=episodes_answered,
        sightings=handed(sightings_answered),
        visits=needed(["tours", "detections", "segments"], "results/visits/{scene}.json"),
        maps=needed(["maps"], "results/maps/{scene}.npz"),
        maintained=needed(["maintained"], "results/maintained/{scene}.npz"),
        dualmap=needed(["dualmap"], "results/dualmap/{scene}.npz"),
        detections=needed(["detections"], "results/detections/{scene}.npz"),
        segments=needed(["segments"], "results/segments/{scene}.npz"),
        labels=labels_of_map,
        scenes=scenes_named,
        nouns=needed(["maps", "maintained", "dualmap", "detections", "segments"], "results/nouns.npz"),
        networks=needed(["networks"], *weights("detector.weights", "encoder.weights", "encoder.model")),
    output:
        predictions="results/predictions/{of}{arm}.jsonl",
    log:
        "logs/predictions/{of}{arm}.log",
    benchmark:
        "benchmarks/predictions/{of}{arm}.tsv"
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    resources:
        gpu=network_gpu,
    params:
        constants=stage_of_arm("predictions"),
    script:
        "../scripts/predictions.py"
