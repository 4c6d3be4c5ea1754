# The detections of a tour are kept in results/journal/detections/ by the content of what was looked at: identical tours are seen once.


rule detections:
    input:
        episodes=episodes_of_scene,
        visits="results/visits/{scene}.json",
        networks=weights("detector.weights", "encoder.weights", "encoder.model"),
    output:
        detections="results/detections/{scene}.npz",
    log:
        "logs/detections/{scene}.log",
    benchmark:
        "benchmarks/detections/{scene}.tsv"
    # The maps of all scenes wait for these, and all embodied arms for the maps: behind the long walks a core would idle at the end.
    priority: 1
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=stage("detections"),
    script:
        "../scripts/detections.py"
