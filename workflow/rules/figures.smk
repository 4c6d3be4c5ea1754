# The figures. No part of the main job: snakemake --cores 1 results/figures
rule figures:
    input:
        episodes=[f"results/episodes/{split}.jsonl" for split in JOB_SPLITS if split == SPLITS[0] or split not in PAPER_SPLITS],
        visits=with_episodes(expand("results/visits/{scene}.json", scene=SCENES)),
    output:
        relations=report("results/figures/relations.png", caption="../report/relations.rst", category="Figures"),
        print="results/figures/relations.pdf",
    log:
        "logs/figures.log",
    params:
        constants=stage("figures"),
    script:
        "../scripts/figures.py"


# What metrics alone are needed for, and the drawing of the agent.
rule charts:
    input:
        metrics=with_episodes(expand("results/metrics/{name}.csv", name=registry.drawn(settings))),
    output:
        agent=report("results/figures/agent.png", caption="../report/agent.rst", category="Figures"),
        budget=report("results/figures/budget.png", caption="../report/budget.rst", category="Figures"),
        controls=report("results/figures/controls.png", caption="../report/controls.rst", category="Figures"),
        coverage=report("results/figures/coverage.png", caption="../report/coverage.rst", category="Figures"),
        difficulty=report("results/figures/difficulty.png", caption="../report/difficulty.rst", category="Figures"),
        memory=report("results/figures/memory.png", caption="../report/memory.rst", category="Figures"),
        sensitivity=report("results/figures/sensitivity.png", caption="../report/sensitivity.rst", category="Figures"),
        print=expand(
            "results/figures/{name}.pdf",
            name=("agent", "budget", "controls", "coverage", "difficulty", "memory", "sensitivity"),
        ),
    log:
        "logs/charts.log",
    params:
        constants=stage("charts"),
    script:
        "../scripts/charts.py"
