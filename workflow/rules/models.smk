# The networks of the default configuration, made again: snakemake --cores 2 results/models. No part of the main job.

from training.floorplans import floor_plans

PLANS = floor_plans(SCENES)


rule pictures:
    output:
        pictures=directory("results/training/pictures/{scene}"),
    log:
        "logs/pictures/{scene}.log",
    benchmark:
        "benchmarks/pictures/{scene}.tsv"
    resources:
        gpu=GPU,
    params:
        constants=stage("pictures"),
    script:
        "../scripts/pictures.py"


rule crops:
    input:
        pictures="results/training/pictures/{scene}",
    output:
        crops="results/training/crops/true/{scene}.npz",
    log:
        "logs/crops/{scene}.log",
    params:
        constants=stage("crops"),
    script:
        "../scripts/crops.py"


rule detector_first:
    input:
        taught=expand("results/training/pictures/{scene}", scene=PLANS.taught),
        held_out=expand("results/training/pictures/{scene}", scene=PLANS.held_out),
    output:
        weights="results/training/detector_first.safetensors",
        curve="results/training/detector_first.jsonl",
    log:
        "logs/detector_first.log",
    benchmark:
        "benchmarks/detector_first.tsv"
    params:
        constants=stage("detector"),
    script:
        "../scripts/detector.py"


# Further, without mosaics, while the encoder learns from what the first detector finds.
rule detector:
    input:
        taught=expand("results/training/pictures/{scene}", scene=PLANS.taught),
        held_out=expand("results/training/pictures/{scene}", scene=PLANS.held_out),
        start="results/training/detector_first.safetensors",
    output:
        weights="results/training/detector.safetensors",
        curve="results/training/detector.jsonl",
    log:
        "logs/detector.log",
    benchmark:
        "benchmarks/detector.tsv"
    params:
        constants=stage("detector"),
    script:
        "../scripts/detector.py"


rule detected:
    input:
        pictures=expand("results/training/pictures/{scene}", scene=(*PLANS.taught, *PLANS.held_out)),
        weights="results/training/detector_first.safetensors",
    output:
        crops=expand("results/training/crops/detected/{scene}.npz", scene=(*PLANS.taught, *PLANS.held_out)),
    log:
        "logs/detected.log",
    params:
        constants=stage("detected"),
    script:
        "../scripts/detected.py"


# On crops of true masks, which need no detector: it is trained meanwhile.
rule encoder_true:
    input:
        taught=expand("results/training/crops/true/{scene}.npz", scene=PLANS.taught),
        true=expand("results/training/crops/true/{scene}.npz", scene=PLANS.held_out),
    output:
        weights="results/training/encoder_true.safetensors",
        curve="results/training/encoder_true.jsonl",
    log:
        "logs/encoder_true.log",
    benchmark:
        "benchmarks/encoder_true.tsv"
    params:
        constants=stage("encoder"),
    script:
        "../scripts/encoder.py"


# And further on crops of what the detector finds as well.
rule encoder:
    input:
        taught=expand("results/training/crops/{masks}/{scene}.npz", masks=("true", "detected"), scene=PLANS.taught),
        true=expand("results/training/crops/true/{scene}.npz", scene=PLANS.held_out),
        detected=expand("results/training/crops/detected/{scene}.npz", scene=PLANS.held_out),
        start="results/training/encoder_true.safetensors",
    output:
        weights="results/training/encoder.safetensors",
        curve="results/training/encoder.jsonl",
    log:
        "logs/encoder.log",
    benchmark:
        "benchmarks/encoder.tsv"
    params:
        constants=stage("encoder"),
    script:
        "../scripts/encoder.py"


rule models:
    input:
        pictures=expand("results/training/pictures/{scene}", scene=(*PLANS.taught, *PLANS.held_out)),
        crops=expand("results/training/crops/{masks}/{scene}.npz", masks=("true", "detected"), scene=PLANS.taught),
        detector="results/training/detector.safetensors",
        detector_first_curve="results/training/detector_first.jsonl",
        detector_curve="results/training/detector.jsonl",
        encoder="results/training/encoder.safetensors",
        encoder_true_curve="results/training/encoder_true.jsonl",
        encoder_curve="results/training/encoder.jsonl",
    output:
        models=directory("results/models"),
    log:
        "logs/models.log",
    params:
        constants=stage("models"),
    script:
        "../scripts/models.py"
