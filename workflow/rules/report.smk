# From answers and scores to metrics, tables, figures and the page about the paper.

import ovman.analysis.registry as registry
import ovman.report.figures

CHARTS = ovman.report.figures.CHARTS
PAGES = ("results", "verdicts", "beyond")
PAPER = os.path.join(ROOT, "ovman", "report", "paper.yaml")

MEMORY = settings.comparisons.memory
RATES = ("benchmark.seed", "success.radius_m", "single_visit.samples", "evaluation.confidence")
COMPARED = ("arms", "comparisons.agent", "comparisons.rungs", "comparisons.pairs", "comparisons.pairings", "comparisons.readings")
SHOWN = (
    *("arms", "splits", "comparisons", "tour", "success", "candidates.delta_min_m", "candidates.spawn_clearance_m"),
    *("association", "grounding", "maps"),
    *("admissibility", "primitives", "mover", "single_visit.samples", "evaluation.confidence", "evaluation.near_miss_m"),
    *("perception.detector.confidence", "perception.detector.min_mask_px"),
)
CHART_MODULES = {place.partition(":")[0] for place in CHARTS.values()}


def metrics(names, splits=JOB_SPLITS):
    """Return files of metrics as inputs that are known once the episodes of splits are."""
    return with_episodes(expand("results/metrics/{name}.csv", name=names), splits)


# One row per arm, seed and episode of a split, and everything that follows from these rows alone.
rule metrics:
    input:
        episodes="results/episodes/{split}.jsonl",
        predictions=lambda wildcards: predictions_of(wildcards.split),
        scores="results/scores/{split}",
    output:
        expand("results/metrics/{{split}}/{name}.csv", name=registry.SPLIT_METRICS),
    log:
        "logs/metrics/{split}.log",
    params:
        constants=pick(*COMPARED, *RATES, "evaluation.near_miss_m", "candidates.delta_min_m"),
        code=digest_code("ovman.analysis.metrics"),
    script:
        "../scripts/report.py"


# The overview, controls next to agents, and arms against each other: of the splits of results/all, and of the paper's.
rule across_splits:
    input:
        metrics=lambda wildcards: expand(
            "results/metrics/{split}/{kind}_{what}.csv",
            split=PAPER_SPLITS if wildcards.folder else JOB_SPLITS,
            kind=("static", "embodied"),
            what=("rates", "outcomes"),
        ),
    output:
        expand("results/metrics/{{folder}}{name}.csv", name=registry.ACROSS_METRICS),
    log:
        "logs/across_splits/{folder}all.log",
    wildcard_constraints:
        folder="(paper/)?",
    params:
        splits=lambda wildcards: PAPER_SPLITS if wildcards.folder else JOB_SPLITS,
        constants=pick(
            *("arms", "comparisons.controls", "comparisons.overview", "comparisons.pairs", "comparisons.ranks"),
            "evaluation.confidence",
        ),
        code=digest_code("ovman.analysis.splits"),
    script:
        "../scripts/report.py"


# Answers of the reference agent to sentences that the parser was not written with.
rule language:
    input:
        episodes="results/episodes/main.jsonl",
        supplied=f"results/predictions/main/{settings.comparisons.agent}.jsonl",
        maps="results/maps/main",
        nouns="results/nouns.npz",
        held_out=os.path.join(ROOT, "ovman", "language", "held_out.yaml"),
    output:
        sentences=expand("results/language/{name}.jsonl", name=("sentences", "relation_inferred", "noun_inferred", "inferred")),
        language="results/metrics/language.csv",
    log:
        "logs/language.log",
    params:
        constants=pick(
            *("comparisons.agent", "grounding", "association", "admissibility.tau_m"),
            *("success.radius_m", "evaluation.confidence"),
        ),
        code=digest_code("ovman.analysis.language"),
    script:
        "../scripts/report.py"


rule perception:
    input:
        episodes=expand("results/episodes/{split}.jsonl", split=PAPER_SPLITS),
        scenes="results/scenes/main.jsonl",
        visits=expand("results/visits/{split}.jsonl", split=PAPER_SPLITS),
        detections=expand("results/detections/{split}", split=PAPER_SPLITS),
        nouns="results/nouns.npz",
    output:
        perception="results/metrics/perception.csv",
        backprojection="results/metrics/backprojection.csv",
    log:
        "logs/perception.log",
    params:
        constants=pick("camera.field_of_view_deg", "perception.detector.min_mask_px"),
        code=digest_code("ovman.analysis.perception"),
    script:
        "../scripts/report.py"


# Colours and extents of what is detected. The weights of the cues are fitted on each split and tested on all.
rule appearance:
    input:
        episodes=expand("results/episodes/{split}.jsonl", split=PAPER_SPLITS),
        predictions=expand("results/predictions/{split}/{arm}.jsonl", split=PAPER_SPLITS, arm=settings.appearance.agent),
        scenes=expand("results/scenes/{split}.jsonl", split=PAPER_SPLITS),
        visits=expand("results/visits/{split}.jsonl", split=PAPER_SPLITS),
        detections=expand("results/detections/{split}", split=PAPER_SPLITS),
        maps=expand("results/maps/{split}", split=PAPER_SPLITS),
    output:
        appearance="results/metrics/appearance.csv",
    log:
        "logs/appearance.log",
    threads: HALF
    params:
        constants=pick(
            *("appearance", "association", "admissibility.tau_m", "success.radius_m", "evaluation.confidence"),
            "camera.field_of_view_deg",
        ),
        code=digest_code("ovman.analysis.appearance"),
    script:
        "../scripts/report.py"


rule fragments:
    input:
        episodes="results/episodes/main.jsonl",
        predictions=f"results/predictions/main/{MEMORY.arm}.jsonl",
        scenes="results/scenes/main.jsonl",
        detections="results/detections/main",
        maps="results/maps/main",
    output:
        fragments="results/metrics/fragments.csv",
    log:
        "logs/fragments.log",
    params:
        constants=pick("comparisons.memory.arm", "success.radius_m", "perception.detector.min_mask_px"),
        code=digest_code("ovman.analysis.maps"),
    script:
        "../scripts/report.py"


rule dualmap_objects:
    input:
        dualmap="results/dualmap/main",
    output:
        objects="results/metrics/dualmap.csv",
    log:
        "logs/dualmap_objects.log",
    params:
        code=digest_code("ovman.analysis.maps"),
    script:
        "../scripts/report.py"


# The agent of the memory experiments, asked again: under other association gates, and REMOVED as if it had been FORMER.
rule probes:
    input:
        episodes="results/episodes/main.jsonl",
        maps="results/maps/main",
        nouns="results/nouns.npz",
    output:
        "results/metrics/gate_sweep.csv",
        "results/metrics/read_as.csv",
    log:
        "logs/probes.log",
    params:
        arm=job_of_arm(settings, MEMORY.arm),
        constants=pick(
            *("comparisons.memory.arm", "gate_sweep", "association.gate_m", "candidates.delta_min_m"),
            *("admissibility.min_mask_px", "success.radius_m", "evaluation.confidence", *own_constants(ARMS[MEMORY.arm])),
        ),
        code=digest_code("ovman.analysis.probes", ARMS[MEMORY.arm].agent.partition(":")[0]),
    script:
        "../scripts/report.py"


rule sensitivity:
    input:
        admissions="results/readmitted/admissions.jsonl",
        episodes="results/readmitted/episodes.jsonl",
        arm=f"results/readmitted/predictions/{MEMORY.arm}.jsonl",
        baseline=f"results/readmitted/predictions/{MEMORY.baseline}.jsonl",
    output:
        sensitivity="results/metrics/sensitivity.csv",
    log:
        "logs/sensitivity.log",
    params:
        constants=pick(*JUDGING, "sensitivity", "comparisons.memory", *RATES),
        code=digest_code("ovman.analysis.probes"),
    script:
        "../scripts/report.py"


# The same within the measured tolerances of the thresholds.
rule tolerances:
    input:
        trials="results/trials/main.jsonl",
        released="results/episodes/main.jsonl",
        episodes="results/readmitted/episodes.jsonl",
        arm=f"results/readmitted/predictions/{MEMORY.arm}.jsonl",
        baseline=f"results/readmitted/predictions/{MEMORY.baseline}.jsonl",
    output:
        tolerances="results/metrics/tolerances.csv",
    log:
        "logs/tolerances.log",
    params:
        constants=pick(*JUDGING, "sensitivity", "tolerances", "comparisons.memory", *RATES),
        code=digest_code("ovman.analysis.probes", "ovman.generation.readmission"),
    script:
        "../scripts/report.py"


# The tables of the paper: splits `main` and `multi`, every arm, the statistics, the audit of rejections.
rule tables:
    input:
        # Plans the episodes of all splits at once. Without it each split would wait for the one before.
        episodes=expand("results/episodes/{split}.jsonl", split=PAPER_SPLITS),
        metrics=metrics(registry.paper_tables(settings), PAPER_SPLITS),
        notes=expand("results/notes/{plugin}.json", plugin=dict.fromkeys(arm.made_by for arm in ARMS.values() if arm.made_by)),
    output:
        tables=report(
            directory("results/tables"),
            caption="../report/tables.rst",
            category="Tables",
            patterns=["{table}.csv"],
            labels={"table": "{table}"},
        ),
    log:
        "logs/tables.log",
    params:
        constants=pick(*SHOWN),
        code=digest_code("ovman.report.tables"),
    script:
        "../scripts/report.py"


# The tables that the other splits add, and those across all splits.
rule all_tables:
    input:
        tables="results/tables",
        episodes=expand("results/episodes/{split}.jsonl", split=JOB_SPLITS),
        metrics=metrics(registry.all_tables(settings)),
    output:
        tables=report(
            directory("results/all"),
            caption="../report/tables.rst",
            category="Tables of all splits",
            patterns=["{table}.csv"],
            labels={"table": "{table}"},
        ),
    log:
        "logs/all_tables.log",
    params:
        constants=pick("arms", "splits", "success.radius_m", "evaluation.confidence"),
        code=digest_code("ovman.report.tables"),
    script:
        "../scripts/report.py"


# The tables of any split: snakemake --cores 2 results/splits/dev
rule split_tables:
    input:
        metrics=lambda wildcards: metrics(registry.split_tables(settings, wildcards.split))(wildcards),
    output:
        tables=directory("results/splits/{split}"),
    log:
        "logs/split_tables/{split}.log",
    params:
        constants=pick("arms", "splits", "success.radius_m", "evaluation.confidence"),
        code=digest_code("ovman.report.tables"),
    script:
        "../scripts/report.py"


# The task, drawn from recorded tours: snakemake --cores 2 results/figures/relations.png
rule relations:
    input:
        episodes=expand("results/episodes/{split}.jsonl", split=["main", *(one for one in JOB_SPLITS if SPLITS[one].homes)]),
        visits=with_episodes(["results/visits/main.jsonl"]),
    output:
        relations=report("results/figures/relations.png", caption="../report/relations.rst", category="Figures"),
        print="results/figures/relations.pdf",
    log:
        "logs/relations.log",
    params:
        constants=pick("camera", "admissibility.min_mask_px"),
        code=digest_code("ovman.report.figures.relations"),
    script:
        "../scripts/report.py"


rule figures:
    input:
        metrics=metrics(registry.DRAWN),
        paper=PAPER,
    output:
        figures=expand("results/figures/{name}.{suffix}", name=CHARTS, suffix=("png", "pdf")),
    log:
        "logs/figures.log",
    params:
        constants=pick("arms", "splits", "comparisons.agent", "comparisons.difficulty", "comparisons.controls", "paper"),
        code=digest_code("ovman.report.figures", *CHART_MODULES),
    script:
        "../scripts/report.py"


# The comparison with the paper, every statement of it, and what goes beyond it.
rule pages:
    input:
        metrics=metrics(registry.compared(settings)),
        templates=expand(
            os.path.join(ROOT, "ovman", "report", "{name}.md.j2"), name=(*(f"{page}_page" for page in PAGES), "statements")
        ),
        sources=[PAPER, *expand(os.path.join(ROOT, "ovman", "report", "{name}.yaml"), name=("choices", "times"))],
    output:
        pages=report(
            expand("results/{name}.md", name=PAGES),
            caption="../report/paper_comparison.rst",
            category="Comparison with the paper",
        ),
    log:
        "logs/pages.log",
    params:
        constants=pick(*SHOWN, "camera", "paper", "benchmark.backend", "perception.detector", "perception.encoder"),
        code=digest_code("ovman.report.results_page"),
    script:
        "../scripts/report.py"
