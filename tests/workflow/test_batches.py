"""Arms without networks drive in several scenes a job; which, no other job and no profile needs to know."""

from __future__ import annotations

import os
import re

import yaml

from ovman.settings import Kind, Need
from ovman.workflow.resources import PROFILE
from tests.workflow import forked
from tests.workflow.conftest import ROOT, TINY, World
from tests.workflow.test_reruns import CONFIG

SCENES = ["FloorPlan227", "FloorPlan204", "FloorPlan7"]
DRIVING = [arm for arm in CONFIG.arms.values() if arm.kind is Kind.EMBODIED and arm.cut_from is None]
LOOKING = [arm.name for arm in DRIVING if Need.NETWORKS in arm.needs]
FURTHER = {name: split for name, split in CONFIG.splits.items() if split.in_main_job and name != "main"}
OF_SPLITS = [name for split in FURTHER.values() for name in split.arms]
BATCHED = sum(1 + OF_SPLITS.count(arm.name) for arm in DRIVING if arm.name not in LOOKING)
"""How many arms without networks drive, each split apart."""


def planned(world: World, size: int) -> dict[str, int]:
    """Count the jobs of each rule for all runs. The runs are named, because the tables wait for the episodes."""
    splits = {name: {*split.arms} for name, split in FURTHER.items()}
    of = ["", *(f"{name}/" for name in splits)]
    arms = {"": {arm.name for arm in DRIVING}} | {f"{name}/": {arm.name for arm in DRIVING} & splits[name] for name in splits}
    runs = [f"results/rollouts/{one}{arm}/seed0/{scene}.jsonl" for one in of for arm in sorted(arms[one]) for scene in SCENES]
    found = world.planned({"splits": {"main": {"scenes": SCENES}}, "evaluation": {"scenes_per_job": size}}, runs)
    return {rule: jobs for rule, jobs in found.items() if rule.startswith("rollouts")}


def test_a_job_takes_so_many_scenes_as_the_settings_say(tmp_path):
    world = World(tmp_path)
    alone = len(LOOKING) * len(SCENES)
    assert LOOKING == ["cow"]
    assert planned(world, 5) == {"rollouts": alone, "rollouts_1": BATCHED}
    assert planned(world, 2) == {"rollouts": alone + BATCHED, "rollouts_1": BATCHED}
    assert planned(world, 1) == {"rollouts": alone + BATCHED * len(SCENES)}


def test_a_batch_asks_a_cluster_for_what_its_stage_asks(tmp_path):
    overlay = tmp_path / "overlay.yaml"
    overlay.write_text(yaml.safe_dump({"splits": {"main": {"scenes": SCENES}}}))
    asked = yaml.safe_load(PROFILE.read_text())["set-resources"]["rollouts"]
    arguments = ["--profile", "profiles/slurm", "--dry-run", "--directory", str(tmp_path)]
    targets = [f"results/rollouts/{arm}/seed0/FloorPlan204.jsonl" for arm in ("oracle_check", "two_visits_oracle_positions")]
    said = forked.snakemake([*arguments, "--configfile", str(TINY), str(overlay), "--", *targets], ROOT, os.environ)
    assert said.returncode == 0, said.stdout
    found = re.findall(r"^ *rule rollouts_1:\n(.*?resources: .*?)$", said.stdout, re.MULTILINE | re.DOTALL)
    assert len(found) == len(targets) and said.stdout.count("Group job driving") == 1
    for name, value in asked.items():
        assert all(f"{name}={value.removesuffix(' * attempt')}" in job for job in found)
