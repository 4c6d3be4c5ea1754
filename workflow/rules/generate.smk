# From floor plans to certified episodes: Algorithm 1 of the paper, one job per stage and split.

GAIT = ("mover.pause_probability", "mover.turn_probability")
DRAWN = (
    *("name", "in_main_job", "scenes", "homes", "changes", "crossed", "second_tour", "light", "sensors", "draws", "tries"),
    *("off_grid", "rules"),
)
RUNNING = ("benchmark.seed", "benchmark.backend", "camera", "primitives", "success.sweep_deg", *GAIT)
JUDGING = (
    *("candidates.delta_min_m", "candidates.spawn_clearance_m", "success.radius_m", "success.visible_px"),
    *("admissibility.tau_m", "admissibility.min_mask_px", "admissibility.validity_radius_m"),
    *("admissibility.drift_tolerance_m", "admissibility.motion_m", "admissibility.mover_spread_m"),
)
PROTOCOL = ("benchmark.seed", "benchmark.backend", "camera", "primitives", "mover", "success")


# The Unity build's requirements. The embedded engine has none.
rule simulator:
    output:
        simulator="results/simulator.txt",
    log:
        "logs/simulator.log",
    resources:
        gpu=GPU,
    params:
        constants=pick("benchmark.backend"),
        code=digest_code("ovman.doctor.checks"),
    script:
        "../scripts/generate.py"


# `ancient`: a simulator that passed its check once is not checked again when the check changes.
rule scenes:
    input:
        simulator=[ancient("results/simulator.txt")] if GPU else [],
        houses=houses_of,
    output:
        scenes="results/scenes/{split}.jsonl",
    log:
        "logs/scenes/{split}.log",
    threads: HALF
    resources:
        gpu=GPU,
    params:
        scenes=scenes_of,
        constants=pick(
            "benchmark.backend", "camera", "primitives.step_m", "primitives.turn_deg", "tour.waypoints", "mover.step_m"
        ),
        code=digest_code("ovman.generation.scenes"),
    script:
        "../scripts/generate.py"


rule candidates:
    input:
        scenes="results/scenes/{split}.jsonl",
    output:
        candidates="results/candidates/{split}.jsonl",
    log:
        "logs/candidates/{split}.log",
    threads: HALF
    params:
        constants=pick_of_split(
            DRAWN,
            *("benchmark.seed", "candidates", "sensors", "tour.headings", "mover", "primitives.step_m"),
            *("admissibility.mover_spread_m", "success.radius_m"),
        ),
        code=digest_code("ovman.generation.candidates"),
    script:
        "../scripts/generate.py"


rule trials:
    input:
        scenes="results/scenes/{split}.jsonl",
        candidates="results/candidates/{split}.jsonl",
    output:
        trials="results/trials/{split}.jsonl",
    log:
        "logs/trials/{split}.log",
    threads: HALF
    resources:
        gpu=GPU,
    params:
        constants=pick(
            *("benchmark.seed", "benchmark.backend", "camera", "primitives.step_m", "primitives.turn_deg"),
            *("measurement", "success.sweep_deg", *GAIT),
        ),
        code=digest_code("ovman.generation.trials"),
    script:
        "../scripts/generate.py"


rule admissible:
    input:
        trials="results/trials/{split}.jsonl",
    output:
        admissible="results/admissible/{split}.jsonl",
    log:
        "logs/admissible/{split}.log",
    params:
        constants=pick_of_split(("crossed",), *JUDGING),
        code=digest_code("ovman.generation.verdict"),
    script:
        "../scripts/generate.py"


rule certified:
    input:
        trials="results/trials/{split}.jsonl",
        admissible="results/admissible/{split}.jsonl",
    output:
        certified="results/certified/{split}.jsonl",
    log:
        "logs/certified/{split}.log",
    threads: HALF
    resources:
        gpu=GPU,
    params:
        constants=pick(*RUNNING, "admissibility.runs"),
        code=digest_code("ovman.generation.certification"),
    script:
        "../scripts/generate.py"


# A checkpoint: if the episodes are equal to the earlier ones, nothing that follows them runs (`with_episodes` in common.smk).
checkpoint episodes:
    input:
        trials="results/trials/{split}.jsonl",
        admissible="results/admissible/{split}.jsonl",
        certified="results/certified/{split}.jsonl",
    output:
        episodes="results/episodes/{split}.jsonl",
        sightings="results/sightings/{split}.jsonl",
        rejections="results/metrics/{split}/rejections.csv",
    log:
        "logs/episodes/{split}.log",
    params:
        constants=pick_of_split(
            (*DRAWN, "episodes"),
            "benchmark.allow_short_split",
            *PROTOCOL,
        ),
        code=digest_code("ovman.generation.release"),
    script:
        "../scripts/generate.py"


# Admissibility under the settings of section `sensitivity`: the trials that any of them admits become episodes of their own.
checkpoint readmitted:
    input:
        trials="results/trials/main.jsonl",
        released="results/episodes/main.jsonl",
    output:
        episodes="results/readmitted/episodes.jsonl",
        admissions="results/readmitted/admissions.jsonl",
    log:
        "logs/readmitted.log",
    params:
        constants=pick(*JUDGING, *PROTOCOL, "sensitivity"),
        code=digest_code("ovman.generation.readmission"),
    script:
        "../scripts/generate.py"


# Recorded tours are no outputs of the rule: Snakemake would delete them before it reruns the job, and most of them would be recorded
# again to the same bytes. Their manifest stands for them: it has a digest of the content of each tour.
rule tours:
    input:
        episodes="results/episodes/{split}.jsonl",
    output:
        visits="results/visits/{split}.jsonl",
    log:
        "logs/tours/{split}.log",
    # First what others wait for.
    priority: 1
    threads: HALF
    resources:
        gpu=GPU,
    params:
        constants=pick("measurement.min_mask_px"),
        code=digest_code("ovman.evaluation.tours"),
    script:
        "../scripts/generate.py"


# Tours of the released episodes are there by then.
use rule tours as readmitted_tours with:
    input:
        episodes="results/readmitted/episodes.jsonl",
        released="results/visits/main.jsonl",
    output:
        visits="results/readmitted/visits.jsonl",
    log:
        "logs/readmitted_tours.log",
    priority: 0
