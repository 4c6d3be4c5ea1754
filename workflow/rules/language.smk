# The predictions of the arm two_visits, asked by sentences that the parser was not made with, beside those of the arm itself.
rule language:
    input:
        episodes="results/episodes/main.jsonl",
        supplied="results/predictions/two_visits.jsonl",
        maps=expand("results/maps/{scene}.npz", scene=SCENES),
        nouns="results/nouns.npz",
        held_out=os.path.join(workflow.basedir, "ovman", "language", "held_out.yaml"),
    output:
        sentences="results/language/sentences.jsonl",
        relation_inferred="results/language/two_visits_relation_inferred.jsonl",
        inferred="results/language/two_visits_inferred.jsonl",
        language="results/metrics/language.csv",
    log:
        "logs/language.log",
    benchmark:
        "benchmarks/language.tsv"
    params:
        constants=stage("language"),
    script:
        "../scripts/language.py"
