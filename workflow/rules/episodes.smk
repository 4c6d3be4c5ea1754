# One job releases one split, so that the episodes of a split depend on no other split.
#
# Checkpoints: if the episodes are equal to the earlier ones, nothing that follows them runs (`with_episodes` in common.smk).


checkpoint episodes:
    input:
        trials=of_split_scenes("results/trials/{scene}.jsonl"),
        admissible=of_split_scenes("results/admissible/{scene}.jsonl"),
        certified=of_split_scenes("results/certified/{scene}.jsonl"),
    output:
        episodes="results/episodes/main.jsonl",
        sightings="results/episodes/sightings.jsonl",
        rejections="results/metrics/main/rejections.csv",
    log:
        "logs/episodes.log",
    benchmark:
        "benchmarks/episodes.tsv"
    params:
        constants=stage("episodes"),
    script:
        "../scripts/episodes.py"


checkpoint split_episodes:
    input:
        trials=of_split_scenes("results/trials/{scene}.jsonl"),
        admissible=of_split_scenes("results/admissible/{scene}.jsonl"),
        certified=of_split_scenes("results/certified/{scene}.jsonl"),
    output:
        episodes="results/episodes/{split}.jsonl",
        sightings="results/episodes/{split}_sightings.jsonl",
        rejections="results/metrics/{split}/rejections.csv",
    log:
        "logs/split_episodes/{split}.log",
    benchmark:
        "benchmarks/split_episodes/{split}.tsv"
    params:
        constants=stage("episodes"),
    script:
        "../scripts/episodes.py"
