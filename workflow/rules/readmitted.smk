# Admissibility under the settings of section sensitivity. Trials that only some of them admit have no detections yet; the maps of all
# that are concerned, and what two arms answer to them, lie in results/readmitted/.


checkpoint readmitted:
    input:
        trials=expand("results/trials/{scene}.jsonl", scene=SCENES),
        released="results/episodes/main.jsonl",
    output:
        episodes="results/readmitted/episodes.jsonl",
        admissions="results/readmitted/admissions.jsonl",
    log:
        "logs/readmitted.log",
    benchmark:
        "benchmarks/readmitted.tsv"
    params:
        constants=stage("readmitted"),
    script:
        "../scripts/readmitted.py"


# After the detections of the episodes, whose tours are then known.
rule readmitted_maps:
    input:
        episodes="results/readmitted/episodes.jsonl",
        visits=expand("results/visits/{scene}.json", scene=SCENES),
        detections=expand("results/detections/{scene}.npz", scene=SCENES),
        networks=weights("detector.weights", "encoder.weights", "encoder.model"),
    output:
        maps=expand("results/readmitted/maps/{scene}.npz", scene=SCENES),
    log:
        "logs/readmitted_maps.log",
    benchmark:
        "benchmarks/readmitted_maps.tsv"
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=stage("readmitted_maps"),
    script:
        "../scripts/readmitted_maps.py"


rule readmitted_predictions:
    input:
        episodes="results/readmitted/episodes.jsonl",
        maps=expand("results/readmitted/maps/{scene}.npz", scene=SCENES),
        nouns="results/nouns.npz",
    output:
        predictions="results/readmitted/predictions/{arm}.jsonl",
    log:
        "logs/readmitted_predictions/{arm}.log",
    benchmark:
        "benchmarks/readmitted_predictions/{arm}.tsv"
    params:
        constants=stage_of_arm("readmitted_predictions"),
    script:
        "../scripts/readmitted_predictions.py"


rule sensitivity:
    input:
        admissions="results/readmitted/admissions.jsonl",
        episodes="results/readmitted/episodes.jsonl",
        arm=f"results/readmitted/predictions/{settings.comparisons.memory.arm}.jsonl",
        baseline=f"results/readmitted/predictions/{settings.comparisons.memory.baseline}.jsonl",
    output:
        sensitivity="results/metrics/sensitivity.csv",
    log:
        "logs/sensitivity.log",
    benchmark:
        "benchmarks/sensitivity.tsv"
    params:
        constants=stage("sensitivity"),
    script:
        "../scripts/sensitivity.py"
