# Controls and the agents that they are set beside, of all splits of the main job in one file.
JUDGED = [kind.value for kind in Kind]
for name in JOB_SPLITS[1:]:
    JUDGED += [name] + [f"{name}_embodied"] * bool(arms_of_split(name, Kind.EMBODIED))


rule controls:
    input:
        rates=expand("results/metrics/{of}_rates.csv", of=JUDGED),
        outcomes=expand("results/metrics/{of}_outcomes.csv", of=JUDGED),
    output:
        controls="results/metrics/controls.csv",
        coverage="results/metrics/coverage.csv",
        split_significance="results/metrics/split_significance.csv",
    log:
        "logs/controls.log",
    params:
        constants=stage("controls"),
    script:
        "../scripts/controls.py"
