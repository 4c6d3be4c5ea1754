# One job runs a scene under all seeds: the simulator starts once.
rule executions:
    input:
        episodes="results/episodes/main.jsonl",
        trials="results/trials/{scene}.jsonl",
        maps=own("results/maps/{scene}.npz"),
        nouns=own("results/nouns.npz"),
    output:
        **{f"seed{seed}": f"results/executions/{{arm}}/seed{seed}/{{scene}}.jsonl" for seed in SEEDS},
    log:
        "logs/executions/{arm}/{scene}.log",
    benchmark:
        "benchmarks/executions/{arm}/{scene}.tsv"
    retries: 2
    resources:
        gpu=GPU,
    params:
        constants=stage("executions"),
    script:
        "../scripts/executions.py"
