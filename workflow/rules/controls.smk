# What is said of all splits of the main job in one file: who reaches what, controls beside agents, arm against arm.
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
        overview="results/metrics/overview.csv",
        split_significance="results/metrics/split_significance.csv",
    log:
        "logs/controls.log",
    params:
        constants=stage("controls"),
    script:
        "../scripts/controls.py"
