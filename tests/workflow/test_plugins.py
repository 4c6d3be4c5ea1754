"""A plug-in beside the overlay that names it: its section, its stage and its rule, and what a change in it reruns."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from ovman.records.note import Note, NoteError, sentence
from tests.workflow.conftest import World

PLUGIN = '''
from pathlib import Path

from ovman.settings import Section
from ovman.settings.plugins import Plugin


class Weather(Section):
    """Section `weather`."""

    wind: int


HERE = Path(__file__).parent
PLUGINS = (Plugin("weather", Weather, {"forecast": ("weather.*", "benchmark.seed")}, HERE / "weather.smk", HERE),)
'''
RULES = """
rule forecast:
    output:
        forecast="results/forecast.json",
    log:
        "logs/forecast.log",
    params:
        constants=stage("forecast"),
    script:
        "forecast.py"
"""
SCRIPT = """
import json

from ovman.workflow.job import job

with job(snakemake) as work:
    from weather.model import twice

    wind, seed = work.constants.weather.wind, work.constants.benchmark.seed
    work.output("forecast").write_text(json.dumps([twice(wind), seed]))
"""
MODEL = "def twice(x):\n    return 2 * x\n"
FORECAST = "results/forecast.json"


@pytest.fixture
def beside(tmp_path: Path) -> World:
    """A world with the plug-in beside its overlay."""
    package = tmp_path / "weather"
    package.mkdir()
    for name, text in {
        "__init__.py": "",
        "plugin.py": PLUGIN,
        "model.py": MODEL,
        "weather.smk": RULES,
        "forecast.py": SCRIPT,
    }.items():
        (package / name).write_text(text)
    return World(tmp_path)


def overlay(**section: Any) -> dict[str, Any]:
    return {"plugins": {"weather": "weather.plugin"}, "weather": {"wind": 3} | section}


def planned(world: World, **section: Any) -> bool:
    """Whether a dry run plans the job."""
    said = world.snakemake("--dry-run", overlay=overlay(**section), target=FORECAST)
    assert said.returncode == 0, said.stdout
    return "rule forecast" in said.stdout


def test_its_job_has_its_settings_and_reruns_with_what_it_depends_on(beside: World):
    said = beside.snakemake(overlay=overlay(), target=FORECAST)
    assert said.returncode == 0, said.stdout
    assert json.loads((beside.directory / FORECAST).read_text()) == [6, 0]
    assert not planned(beside) and planned(beside, wind=4)
    package = beside.directory / "weather"
    # The module of the plug-in chooses the parameter, which is compared itself.
    (package / "plugin.py").write_text(PLUGIN + "\nMORE = 1\n")
    (package / "model.py").write_text("# Why.\n" + MODEL)
    assert not planned(beside)
    (package / "model.py").write_text(MODEL.replace("2", "3"))
    assert planned(beside)


@pytest.mark.parametrize(
    ("old", "new", "line"),
    [
        ('"weather", W', '"wether", W', "plugins.weather is weather.plugin, which has no plug-in of that name; it has wether"),
        ('"weather", W', '"cow", W', "plugins.cow is weather.plugin, which is called cow, which is a section of ovman; rename"),
        ('{"forecast"', '{"trials"', "plugins.weather is weather.plugin, which has a stage trials, which is a stage of ovman; "),
        ("class Weather", "class Wea ther", "plugins.weather is weather.plugin, which is not valid Python (line 8: "),
        (
            "import Path",
            "import Paths",
            "plugins.weather is weather.plugin, which cannot be imported (cannot import name '",
        ),
    ],
)
def test_a_module_that_is_no_such_plugin_stops_the_workflow_with_one_line(beside: World, old: str, new: str, line: str):
    (beside.directory / "weather" / "plugin.py").write_text(PLUGIN.replace(old, new))
    name = line.removeprefix("plugins.").partition(" ")[0]
    said = beside.snakemake(overlay={"plugins": {name: "weather.plugin"}, "x-weather": {}}, target=FORECAST)
    assert said.returncode != 0
    lines = [text for text in said.stdout.splitlines() if not text.startswith(("Using workflow specific profile", "Config file"))]
    assert len(lines) == 1 and lines[0].startswith(f"overlay.yaml: {line}")


def test_a_note_says_what_it_was_given_and_another_file_is_refused_in_one_line(tmp_path: Path):
    path = tmp_path / "weather.json"
    for note in (Note(system="Weather", missing="wind is missing; run: blow"), Note(system="Weather")):
        note.write(path)
        assert Note.read(path) == note
    assert sentence(path) is None
    for text in ("{}", "[", '{"schema": "ovman-note/2", "system": "a", "missing": ""}'):
        path.write_text(text)
        with pytest.raises(NoteError, match=r"weather.json: is no record 'ovman-note/1' \(.*\); remove it") as caught:
            Note.read(path)
        assert "\n" not in str(caught.value)
