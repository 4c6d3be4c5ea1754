# What each setting of a split costs each static arm: `snakemake results/ablation/{split}/table`. No part of the main job: the tours
# of each variant are recorded and looked at, which takes longer than the split itself.


rule ablation_episodes:
    input:
        episodes="results/episodes/{split}.jsonl",
    output:
        episodes=expand("results/ablation/{{split}}/episodes/{variant}.jsonl", variant=VARIANTS),
    log:
        "logs/ablation_episodes/{split}.log",
    benchmark:
        "benchmarks/ablation_episodes/{split}.tsv"
    params:
        constants=stage("ablation_episodes"),
    script:
        "../scripts/ablation_episodes.py"


rule ablated_tours:
    input:
        episodes=expand("results/ablation/{{split}}/episodes/{variant}.jsonl", variant=VARIANTS),
    output:
        visits="results/ablation/{split}/visits/{scene}.json",
    log:
        "logs/ablated_tours/{split}/{scene}.log",
    benchmark:
        "benchmarks/ablated_tours/{split}/{scene}.tsv"
    resources:
        gpu=GPU,
    params:
        constants=stage("ablated_tours"),
    script:
        "../scripts/ablated_tours.py"


rule ablated_maps:
    input:
        visits="results/ablation/{split}/visits/{scene}.json",
        networks=weights("detector.weights", "encoder.weights", "encoder.model"),
    output:
        maps="results/ablation/{split}/maps/{scene}.npz",
    log:
        "logs/ablated_maps/{split}/{scene}.log",
    benchmark:
        "benchmarks/ablated_maps/{split}/{scene}.tsv"
    resources:
        gpu=NETWORK_GPU,
    params:
        constants=stage("ablated_maps"),
    script:
        "../scripts/ablated_maps.py"


rule ablated_predictions:
    input:
        episodes="results/ablation/{split}/episodes/{variant}.jsonl",
        visits=lambda wildcards: expand(
            "results/ablation/{split}/visits/{scene}.json", split=wildcards.split, scene=scenes_of_split(wildcards)
        ),
        maps=lambda wildcards: expand(
            "results/ablation/{split}/maps/{scene}.npz", split=wildcards.split, scene=scenes_of_split(wildcards)
        ),
        nouns="results/nouns.npz",
    output:
        predictions="results/ablation/{split}/predictions/{variant}/{arm}.jsonl",
    log:
        "logs/ablated_predictions/{split}/{variant}/{arm}.log",
    benchmark:
        "benchmarks/ablated_predictions/{split}/{variant}/{arm}.tsv"
    wildcard_constraints:
        variant="|".join(VARIANTS),
    params:
        constants=stage_of_arm("ablated_predictions"),
    script:
        "../scripts/ablated_predictions.py"


rule ablation:
    input:
        episodes=expand("results/ablation/{{split}}/episodes/{variant}.jsonl", variant=VARIANTS),
        predictions=with_episodes(
            lambda wildcards: expand(
                "results/ablation/{split}/predictions/{variant}/{arm}.jsonl",
                split=wildcards.split,
                variant=VARIANTS,
                arm=[arm for arm in settings.comparisons.ablation if arm in settings.arms],
            )
        ),
    output:
        rates="results/ablation/{split}/rates.csv",
        table=directory("results/ablation/{split}/table"),
    log:
        "logs/ablation/{split}.log",
    benchmark:
        "benchmarks/ablation/{split}.tsv"
    params:
        constants=stage("ablation"),
    script:
        "../scripts/ablation.py"
