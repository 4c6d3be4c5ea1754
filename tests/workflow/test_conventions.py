"""What holds of the workflow's files: lints, the schema of the settings, and what is used of Snakemake without documentation."""

from __future__ import annotations

import copy
import inspect
import json
import re

import jsonschema
import pytest
import snakemake.api  # noqa: F401 (Snakemake's modules import each other in a circle that begins here)
from snakemake import benchmark
from snakemake.persistence import MetadataRecord
from snakemake.persistence import file as persistence
from snakemake.scheduling.job_scheduler import JobScheduler
from snakemake.script import PythonScript
from snakemake.settings.types import ResourceSettings
from snakemake.workflow import Workflow

from ovman.cli import main
from ovman.settings import schema
from ovman.settings.settings_files import read_merged, with_parts
from ovman.workflow import snakemake_internals
from ovman.workflow.lint import EXPLAINED, findings
from tests.workflow.conftest import ROOT, TINY

TREE = read_merged(with_parts(ROOT / "config.yaml"))
SCHEMA = json.loads(schema.FILE.read_text())


def test_the_schema_is_that_of_the_models():
    assert schema.FILE.read_text() == schema.schema_text(), "the models have changed: python -m ovman.settings.schema"


def test_the_schema_accepts_the_settings_and_refuses_others():
    jsonschema.Draft202012Validator.check_schema(SCHEMA)
    jsonschema.validate(TREE | {"x-notes": [1]}, SCHEMA)
    for section, name, value in (("tour", "waypoints", 0), ("tour", "way", 3), ("success", "radius_m", "1")):
        tree = copy.deepcopy(TREE)
        tree[section][name] = value
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(tree, SCHEMA)


@pytest.mark.parametrize("name", sorted(snakemake_internals.USED))
def test_what_is_used_of_snakemake_without_documentation_is_there(name):
    owner, _, attribute = name.partition(".")
    there = {
        "Workflow": lambda: hasattr(Workflow, attribute) or f"self.{attribute} =" in inspect.getsource(Workflow.__init__),
        "ResourceSettings": lambda: hasattr(ResourceSettings, attribute),
        "JobScheduler": lambda: f"self.{attribute} =" in inspect.getsource(JobScheduler),
        "PythonScript": lambda: list(inspect.signature(PythonScript.execute_script).parameters) == ["self", "fname", "edit"],
        "benchmarked": lambda: [*inspect.signature(benchmark.benchmarked).parameters][:2] == ["pid", "benchmark_record"],
        "FilePersistence": lambda: hasattr(persistence.FilePersistence, attribute),
        "MetadataRecord": lambda: attribute in MetadataRecord.model_fields,
        "Persistence: ": lambda: '"locks"' in inspect.getsource(persistence) and ".lock" in inspect.getsource(persistence),
    }[owner]()
    assert there, (
        f"this Snakemake has no {name}; ovman/workflow/snakemake_internals.py uses it for: {snakemake_internals.USED[name]}"
    )


def test_no_other_module_reaches_into_snakemake():
    """Of the workflow object the Snakefile's helpers read `basedir`, `dryrun` and `is_main_process`, and nothing else."""
    read = {
        name
        for path in sorted((ROOT / "ovman" / "workflow").glob("*.py"))
        for name in re.findall(r"\bworkflow\.(?!smk)([a-z_]+)", path.read_text())
        if path.name != "snakemake_internals.py" and f"ovman.workflow.{name}" not in path.read_text()
    }
    assert read <= {"basedir", "dryrun", "is_main_process"}


def test_lints_are_found_but_for_those_that_are_explained():
    (explained,) = EXPLAINED
    text = f"Lints for rule a (line 1, x.smk):\n    * {explained}:\n      Why.\n    * No log directive defined:\n      Why.\n"
    assert findings(text) == ["rule a (line 1, x.smk): No log directive defined"]
    assert findings("Congratulations, your workflow is in a good condition!\n") == []


def test_the_report_has_every_table_and_its_caption(world, tmp_path):
    said = world.snakemake("--report", str(tmp_path / "report.html"))
    assert said.returncode == 0, said.stdout
    page = (tmp_path / "report.html").read_text()
    tables = [path.stem for path in (world.directory / "results" / "tables").glob("*.csv")]
    assert tables and [name for name in tables if f"{name}.csv" not in page] == []
    assert "A table of the results for the settings of this run" in page


def test_finished_results_are_whole(world, capsys):
    base = ["--config", str(ROOT / "config.yaml"), "--configfile", str(TINY)]
    assert main(["check", str(world.directory / "results"), *base]) == 0, capsys.readouterr().out
