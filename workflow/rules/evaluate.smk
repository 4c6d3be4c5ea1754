# What agents answer to the episodes, and where they drive: one job per arm and split.


rule predictions:
    input:
        episodes="results/episodes/{split}.jsonl",
        sightings=if_arm(reads_sightings, "results/sightings/{split}.jsonl"),
        scenes=if_arm(reads_scenes, "results/scenes/{split}.jsonl"),
        visits=if_arm(needs("tours", "detections", "segments"), "results/visits/{split}.jsonl"),
        maps=if_arm(needs("maps"), "results/maps/{split}"),
        maintained=if_arm(needs("maintained"), "results/maintained/{split}"),
        dualmap=if_arm(needs("dualmap"), "results/dualmap/{split}"),
        detections=if_arm(needs("detections"), "results/detections/{split}"),
        segments=if_arm(needs("segments"), "results/segments/{split}"),
        labels=labels_of_map,
        nouns=if_arm(needs("maps", "maintained", "dualmap", "detections", "segments"), "results/nouns.npz"),
        networks=if_arm(embeds_phrases, *NETWORKS),
    output:
        predictions="results/predictions/{split}/{arm}.jsonl",
    log:
        "logs/predictions/{split}/{arm}.log",
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    resources:
        gpu=network_gpu,
    params:
        arm=entry_of_arm,
        constants=pick_of_arm("admissibility.min_mask_px"),
        code=code_of_arm("ovman.evaluation.predictions"),
    script:
        "../scripts/evaluate.py"


# Under all seeds.
rule rollouts:
    input:
        episodes="results/episodes/{split}.jsonl",
        sightings=if_arm(reads_sightings, "results/sightings/{split}.jsonl"),
        predictions=executed_predictions,
        visits=if_arm(needs("tours", "maps", "detections", "segments"), "results/visits/{split}.jsonl"),
        maps=if_arm(needs("maps"), "results/maps/{split}"),
        dualmap=if_arm(needs("dualmap"), "results/dualmap/{split}"),
        detections=if_arm(needs("detections"), "results/detections/{split}"),
        segments=if_arm(needs("segments"), "results/segments/{split}"),
        nouns=if_arm(needs("maps", "dualmap", "detections", "segments"), "results/nouns.npz"),
        networks=if_arm(embeds_phrases, *NETWORKS),
    output:
        rollouts="results/rollouts/{split}/{arm}.jsonl",
    log:
        "logs/rollouts/{split}/{arm}.log",
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    threads: HALF
    resources:
        gpu=lambda wildcards: max(GPU, network_gpu(wildcards)),
    params:
        arm=entry_of_arm,
        seeds=settings.evaluation.seeds,
        constants=pick_of_arm("admissibility.min_mask_px"),
        code=code_of_arm("ovman.evaluation.rollouts"),
    script:
        "../scripts/evaluate.py"


# One job per split: judging takes less time than starting a job.
rule scores:
    input:
        episodes="results/episodes/{split}.jsonl",
        rollouts=rollouts_of,
    output:
        scores=directory("results/scores/{split}"),
    log:
        "logs/scores/{split}.log",
    params:
        arms=lambda wildcards: [job_of_arm(settings, name) for name in arms_of(wildcards.split, Kind.EMBODIED)],
        constants=pick(),
        code=digest_code("ovman.evaluation.scores"),
    script:
        "../scripts/evaluate.py"


rule readmitted_predictions:
    input:
        episodes="results/readmitted/episodes.jsonl",
        maps="results/readmitted/maps",
        nouns="results/nouns.npz",
    output:
        predictions="results/readmitted/predictions/{arm}.jsonl",
    log:
        "logs/readmitted_predictions/{arm}.log",
    params:
        arm=entry_of_arm,
        constants=pick_of_arm("admissibility.min_mask_px"),
        code=code_of_arm("ovman.evaluation.predictions"),
    script:
        "../scripts/evaluate.py"
