# What the networks see in the recorded tours, and the maps that agents build of it. One folder per split, one file per scene in it.

NETWORKS = weights("detector.weights", "encoder.weights", "encoder.model")
MAPPING = ("camera.field_of_view_deg", "perception", "maps")


rule nouns:
    input:
        networks=weights("encoder.weights", "encoder.model"),
    output:
        nouns="results/nouns.npz",
    log:
        "logs/nouns.log",
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=pick("perception.device", "perception.trust_pickles", "perception.encoder"),
        code=digest_code("ovman.perception.networks", "ovman.language.vocabulary"),
    script:
        "../scripts/perceive.py"


rule detections:
    input:
        episodes="results/episodes/{split}.jsonl",
        visits="results/visits/{split}.jsonl",
        networks=NETWORKS,
    output:
        detections=directory("results/detections/{split}"),
    log:
        "logs/detections/{split}.log",
    priority: 1
    threads: HALF
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=pick("camera.field_of_view_deg", "perception"),
        code=SIGHT,
    script:
        "../scripts/perceive.py"


rule maps:
    input:
        detections="results/detections/{split}",
    output:
        maps=directory("results/maps/{split}"),
    log:
        "logs/maps/{split}.log",
    params:
        constants=pick("maps"),
        code=digest_code("ovman.perception.maps"),
    script:
        "../scripts/perceive.py"


# The one map of both visits of each episode, for agents that do not tell visits apart.
rule maintained:
    input:
        episodes="results/episodes/{split}.jsonl",
        detections="results/detections/{split}",
    output:
        maintained=directory("results/maintained/{split}"),
    log:
        "logs/maintained/{split}.log",
    params:
        constants=pick("maps"),
        code=digest_code("ovman.perception.maps"),
    script:
        "../scripts/perceive.py"


# Both tours of every episode weighed against each other, for agents that decide on single detections.
rule segments:
    input:
        episodes="results/episodes/{split}.jsonl",
        visits="results/visits/{split}.jsonl",
        detections="results/detections/{split}",
    output:
        segments=directory("results/segments/{split}"),
    log:
        "logs/segments/{split}.log",
    threads: HALF
    params:
        constants=pick("joint.every_px", "joint.tolerance_m", "joint.tolerance_per_m", "joint.part_cells", "joint.doubt"),
        code=digest_code("ovman.evaluation.segments"),
    script:
        "../scripts/perceive.py"


# Which instances the detections truly show, for agents with oracle grounding over their own maps.
rule labels:
    input:
        scenes="results/scenes/{split}.jsonl",
        visits="results/visits/{split}.jsonl",
        detections="results/detections/{split}",
    output:
        labels=directory("results/labels/{split}"),
    log:
        "logs/labels/{split}.log",
    params:
        constants=pick(),
        code=digest_code("ovman.perception.labels"),
    script:
        "../scripts/perceive.py"


# DualMap's dense tours: the recorded views and the frames between them. The seed, camera, primitives, mover and success test are each
# episode's own.
rule walks:
    input:
        scenes="results/scenes/{split}.jsonl",
        episodes="results/episodes/{split}.jsonl",
        visits="results/visits/{split}.jsonl",
        networks=NETWORKS,
    output:
        walks=directory("results/walks/{split}"),
        labels=directory("results/walk_labels/{split}"),
    log:
        "logs/walks/{split}.log",
    priority: 1
    threads: HALF
    resources:
        gpu=max(GPU, NETWORK_GPU),
    params:
        constants=pick("perception", "dualmap.runs", "dualmap.walk", "dualmap.observation"),
        code=digest_code("ovman.agents.dualmap.walks"),
    script:
        "../scripts/perceive.py"


rule dualmap:
    input:
        episodes="results/episodes/{split}.jsonl",
        walks="results/walks/{split}",
    output:
        dualmap=directory("results/dualmap/{split}"),
    log:
        "logs/dualmap/{split}.log",
    threads: HALF
    params:
        constants=pick("dualmap.runs", "dualmap.local_map"),
        code=digest_code("ovman.agents.dualmap.maps"),
    script:
        "../scripts/perceive.py"


# The maps of the tours of all trials that some setting of section `sensitivity` admits.
rule readmitted_maps:
    input:
        episodes="results/readmitted/episodes.jsonl",
        visits="results/readmitted/visits.jsonl",
        networks=NETWORKS,
    output:
        maps=directory("results/readmitted/maps"),
    log:
        "logs/readmitted_maps.log",
    threads: HALF
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=pick(*MAPPING),
        code=digest_code("ovman.perception.maps"),
        sight=SIGHT,
    script:
        "../scripts/perceive.py"
