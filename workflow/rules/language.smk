# What the agent of section `comparisons` answers to sentences that the parser was not made with, beside its own predictions.
rule language:
    input:
        episodes="results/episodes/main.jsonl",
        supplied=f"results/predictions/{settings.comparisons.agent}.jsonl",
        maps=expand("results/maps/{scene}.npz", scene=SCENES),
        nouns="results/nouns.npz",
        held_out=os.path.join(workflow.basedir, "ovman", "language", "held_out.yaml"),
    output:
        sentences="results/language/sentences.jsonl",
        relation_inferred="results/language/relation_inferred.jsonl",
        noun_inferred="results/language/noun_inferred.jsonl",
        inferred="results/language/inferred.jsonl",
        language="results/metrics/language.csv",
    log:
        "logs/language.log",
    benchmark:
        "benchmarks/language.tsv"
    params:
        constants=stage("language"),
    script:
        "../scripts/language.py"
