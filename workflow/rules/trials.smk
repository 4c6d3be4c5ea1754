# The recorded tours lie in results/visits/{scene}/{visit}/. They are no outputs of the rule: Snakemake would delete them before
# it reruns the job, and most of them would be recorded again to the same bytes.


rule trials:
    input:
        candidates="results/candidates/{scene}.jsonl",
        scene="results/scenes/{scene}.json",
    output:
        trials="results/trials/{scene}.jsonl",
    log:
        "logs/trials/{scene}.log",
    benchmark:
        "benchmarks/trials/{scene}.tsv"
    resources:
        gpu=GPU,
    params:
        constants=stage("trials"),
    script:
        "../scripts/trials.py"
