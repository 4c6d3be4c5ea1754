"""The profile for SLURM is in step with the rules and with what was measured."""

from __future__ import annotations

import dataclasses
import os
import re
import subprocess
from pathlib import Path

import pytest
import yaml

from ovman.workflow import resources
from ovman.workflow.resources import LIKE, MEASURED, PROFILE, TRAINING, Measured, ResourcesError
from tests.workflow import forked
from tests.workflow.conftest import ROOT, TINY

NAMES = resources.rules()
TREE = yaml.safe_load(PROFILE.read_text())


def on_cluster() -> set[str]:
    return NAMES.keys() - resources.local()


def test_the_profile_is_written_from_what_was_measured():
    text = resources.profile(PROFILE.read_text(), resources.read(), on_cluster())
    assert PROFILE.read_text() == text, "the profile has changed: python -m ovman.workflow.resources"


def test_every_rule_has_time_and_memory():
    assert TREE["set-resources"].keys() == on_cluster()
    assert resources.local() == {"all"} < NAMES.keys()
    assert all(sorted(asked) == ["mem_mb", "runtime"] for asked in TREE["set-resources"].values())


def test_a_new_rule_is_not_forgotten():
    with pytest.raises(ResourcesError, match="the rule newcomer has no resources for a cluster; run it, then: python -m"):
        resources.resources(resources.read(), {"scenes", "newcomer"})


def test_what_stands_for_other_rules_is_there():
    measured = {one.rule for one in resources.read()}
    assert LIKE.keys() | TRAINING.keys() | measured <= NAMES.keys() and {*LIKE.values()} <= measured
    assert not measured & (LIKE.keys() | TRAINING.keys()), "measured rules need no like"


def test_numbers_leave_headroom_and_grow_with_the_run():
    scene = Measured("trials", 3, True, 100.0, 400.0, 3, 24)
    assert resources.asked(scene) == (20, 1000)  # 100 s x (608/24) x (3/20) x 3, and the least memory
    assert resources.asked(dataclasses.replace(scene, scenes=20, episodes=608)) == (5, 1000)
    assert resources.asked(dataclasses.replace(scene, megabytes=1400.0))[1] == 2500
    whole = dataclasses.replace(scene, of_scene=False, megabytes=160.0)
    assert resources.asked(whole) == (130, 2000)  # 120 MB of its own and 40 x (608/24)
    assert resources.asked(dataclasses.replace(whole, megabytes=500.0))[1] == 3500, "no job of a run exceeds MOST_MB"
    assert resources.asked(dataclasses.replace(whole, scenes=40, episodes=1216, seconds=600.0)) == (30, 1000), "never scaled down"


def test_benchmarks_are_read_by_rule(tmp_path):
    columns = "s\th:m:s\tmax_rss\tmax_vms\tmax_uss\tmax_pss\tio_in\tio_out\tmean_load\tcpu_time"

    def job(name: str, seconds: float, megabytes: str) -> None:
        path = tmp_path / "benchmarks" / f"{name}.tsv"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(f"{columns}\n{seconds}\t0:00:01\t{megabytes}\t-\t-\t-\t-\t-\t-\t-\n")

    job("trials/FloorPlan1", 3.0, "500.0")
    job("trials/FloorPlan2", 4.0, "400.0")
    job("scores/cow", 1.0, "NA")
    job("scores/multi/cow", 2.0, "30.0")
    job("rollouts/multi/cow/FloorPlan1", 9.0, "20.0")
    job("rollouts/cow/FloorPlan1", 8.0, "21.0")
    job("cues", 5.0, "1.0")
    job("cues/FloorPlan6", 6.0, "1.0")
    for name in ("episodes/main.jsonl", "episodes/multi.jsonl", "episodes/sightings.jsonl", "episodes/multi_sightings.jsonl"):
        path = tmp_path / "results" / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("{}\n{}\n{}\n")
    for scene in ("FloorPlan1", "FloorPlan2"):
        (tmp_path / "results" / "scenes").mkdir(exist_ok=True)
        (tmp_path / "results" / "scenes" / f"{scene}.json").touch()
    found = {one.rule: one for one in resources.measured(tmp_path, NAMES)}
    assert found["trials"] == Measured("trials", 2, True, 4.0, 500, 2, 6)
    assert (found["scores"].seconds, found["scores"].megabytes, found["split_scores"].seconds) == (1.0, 0, 2.0)
    assert (found["rollouts"].jobs, found["rollouts"].seconds) == (2, 9.0)
    assert (found["cues"].of_scene, found["cues"].seconds, found["cues_of_scene"].of_scene) == (False, 5.0, True)
    assert found.keys() == {"trials", "scores", "split_scores", "rollouts", "cues", "cues_of_scene"}
    kept = tmp_path / "measured.csv"
    resources.write(found.values(), kept)
    assert resources.read(kept) == sorted(found.values(), key=lambda one: one.rule)


def test_a_folder_without_benchmarks_is_refused(tmp_path, capsys):
    before = MEASURED.read_bytes(), PROFILE.read_bytes()
    assert resources.main([str(tmp_path)]) == 2
    assert (
        capsys.readouterr().err
        == f"{tmp_path / 'benchmarks'}: has no benchmarks; name a directory in which the workflow has run\n"
    )
    assert (MEASURED.read_bytes(), PROFILE.read_bytes()) == before


def test_groups_are_of_rules_that_are_there_and_have_a_size():
    pairs = [entry.split("=") for entry in TREE["groups"]]
    assert {rule for rule, _ in pairs} <= on_cluster() and len({rule for rule, _ in pairs}) == len(pairs)
    sizes = dict(entry.split("=") for entry in TREE["group-components"])
    assert sizes.keys() == {group for _, group in pairs} and all(int(size) > 0 for size in sizes.values())


def test_the_workflow_is_planned_with_the_profile_and_no_group_depends_on_itself(tmp_path):
    # The tables wait for the episodes; the metrics do not.
    said = planned(tmp_path, "results/metrics/controls.csv")
    assert said.returncode == 0, said.stdout
    asked = of_rules(said.stdout)
    for rule, wanted in TREE["set-resources"].items():
        if rule in asked:
            assert asked[rule] == tuple(int(wanted[name].removesuffix(" * attempt")) for name in ("runtime", "mem_mb"))
    assert asked.keys() >= {"scenes", "trials", "predictions", "rollouts", "metrics"} and TREE["cores"] == 1


def planned(directory: Path, target: str) -> subprocess.CompletedProcess[str]:
    arguments = ["--profile", "profiles/slurm", "--dry-run", "--directory", str(directory), "--configfile", str(TINY)]
    return forked.snakemake([*arguments, "--", target], ROOT, os.environ)


def of_rules(text: str) -> dict[str, tuple[int, int]]:
    """Minutes and MB that a dry run prints for each rule."""
    blocks = re.findall(r"^ *rule (\w+):\n(.*?resources: .*?)$", text, re.MULTILINE | re.DOTALL)
    found = {}
    for rule, block in blocks:
        minutes, megabytes = re.search(r"runtime=(\d+)", block), re.search(r"mem_mb=(\d+)", block)
        assert minutes and megabytes, (rule, block)
        found[rule] = int(minutes[1]), int(megabytes[1])
    return found
