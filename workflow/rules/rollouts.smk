# One job runs a scene under all seeds: the simulator starts once.
rule rollouts:
    input:
        episodes=episodes_answered,
        sightings=handed(sightings_answered),
        predictions=executed_answers,
        visits=needed(["tours", "maps", "detections", "segments"], "results/visits/{scene}.json"),
        maps=needed(["maps"], "results/maps/{scene}.npz"),
        dualmap=needed(["dualmap"], "results/dualmap/{scene}.npz"),
        detections=needed(["detections"], "results/detections/{scene}.npz"),
        segments=needed(["segments"], "results/segments/{scene}.npz"),
        nouns=needed(["maps", "dualmap", "detections", "segments"], "results/nouns.npz"),
        networks=needed(["networks"], *weights("detector.weights", "encoder.weights", "encoder.model")),
    output:
        **{f"seed{seed}": f"results/rollouts/{{of}}{{arm}}/seed{seed}/{{scene}}.jsonl" for seed in SEEDS},
    log:
        "logs/rollouts/{of}{arm}/{scene}.log",
    benchmark:
        "benchmarks/rollouts/{of}{arm}/{scene}.tsv"
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    resources:
        gpu=lambda wildcards: max(GPU, network_gpu(wildcards)),
    params:
        constants=stage_of_arm("rollouts"),
    script:
        "../scripts/rollouts.py"
