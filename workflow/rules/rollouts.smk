# One job runs a scene under all seeds: the simulator starts once. An arm without networks runs several scenes in a job: a rule for
# each batch of them (ovman/workflow/batches.py), which comes before the rule of one scene.
BATCHES = batches(SCENES_OF, settings.evaluation.scenes_per_job)
BATCHED = "|".join(arm.name for arm in ARMS if arm.made_by is None and Need.NETWORKS not in arm.needs) or "none"
go_before(workflow, [f"rollouts_{batch.number}" for batch in BATCHES], "rollouts")


rule rollouts:
    input:
        **driven_with(["{scene}"]),
    output:
        **driven(["{scene}"]),
    log:
        "logs/rollouts/{of}{arm}/{scene}.log",
    benchmark:
        "benchmarks/rollouts/{of}{arm}/{scene}.tsv"
    wildcard_constraints:
        arm=OF_NO_PLUGIN,
    resources:
        gpu=lambda wildcards: max(GPU, network_gpu(wildcards)),
    params:
        constants=stage_of_arm("rollouts"),
    script:
        "../scripts/rollouts.py"


for batch in BATCHES:

    rule:
        name:
            f"rollouts_{batch.number}"
        input:
            **driven_with(batch.scenes),
        output:
            **driven(batch.scenes),
        log:
            f"logs/rollouts/{{of}}{{arm}}/{batch.name}.log",
        benchmark:
            f"benchmarks/rollouts/{{of}}{{arm}}/{batch.name}.tsv"
        wildcard_constraints:
            of="|".join("" if split == SPLITS[0] else f"{split}/" for split in batch.splits),
            arm=BATCHED,
        group:
            group_like(workflow, "rollouts")
        resources:
            gpu=GPU,
        params:
            constants=stage_of_arm("rollouts"),
        script:
            "../scripts/rollouts.py"
