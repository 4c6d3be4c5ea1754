# One job runs all seeds of an arm in a scene: starting the simulator costs as much as several runs.


rule executions:
    input:
        episodes="results/episodes/main.jsonl",
        trials="results/trials/{scene}.jsonl",
    output:
        expand("results/executions/{{arm}}/seed{seed}/{{scene}}.jsonl", seed=SEEDS),
    log:
        "logs/executions/{arm}/{scene}.log",
    benchmark:
        "benchmarks/executions/{arm}/{scene}.tsv"
    resources:
        gpu=GPU,
    params:
        constants=stage("executions"),
    script:
        "../scripts/executions.py"
