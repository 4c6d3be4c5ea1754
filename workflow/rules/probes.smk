# The two-visit agent asked again: under other association gates, and REMOVED as if it had been FORMER.
rule probes:
    input:
        episodes="results/episodes/main.jsonl",
        maps=expand("results/maps/{scene}.npz", scene=SCENES),
        nouns="results/nouns.npz",
    output:
        expand("results/metrics/{name}.csv", name=("gate_sweep", "read_as")),
    log:
        "logs/probes.log",
    benchmark:
        "benchmarks/probes.tsv"
    params:
        constants=lambda wildcards: canonical(settings, "probes", settings.comparisons.memory.arm),
    script:
        "../scripts/probes.py"
