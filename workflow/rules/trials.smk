# The recorded tours lie in results/visits/{scene}/{visit}/. They are no outputs of the rule: Snakemake would delete them before it
# reruns the job, and most of them would be recorded again to the same bytes. Their manifest stands for them: it has a digest of the
# content of each tour, and every rule that reads tours has it as input.


rule trials:
    input:
        candidates="results/candidates/{scene}.jsonl",
        scene="results/scenes/{scene}.json",
    output:
        trials="results/trials/{scene}.jsonl",
        visits="results/visits/{scene}.json",
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
