# No part of the main job: snakemake --cores 1 results/figures/relations.png
rule figures:
    input:
        episodes="results/episodes/main.jsonl",
        visits=expand("results/visits/{scene}.json", scene=SCENES),
    output:
        relations=report("results/figures/relations.png", caption="../report/relations.rst", category="Figures"),
    log:
        "logs/figures.log",
    params:
        constants=stage("figures"),
    script:
        "../scripts/figures.py"
