"""Pages of the release: every arm that answers an episode's split is on its page, with all of its runs, and no other arm is."""

from __future__ import annotations

import pytest

from ovman.playback import places
from ovman.report.show.page import page, shown_at_first
from ovman.report.show.verdicts import letters
from ovman.settings import MAIN, Kind, arms_of
from tests.report.show.conftest import ROOT
from tests.report.show.html_reader import Page

SPLITS = (MAIN, "multi", "everyday")


@pytest.fixture(scope="module")
def released():
    """Settings and results of the release, as `ovman show` finds them where there are no results."""
    settings, results, _ = places(ROOT / "data" / "ovman-embedded-v2", None, ROOT / "config.yaml")
    return settings, results


@pytest.mark.parametrize("split", SPLITS)
def test_every_arm_that_is_asked_is_on_the_page(released, split):
    settings, results = released
    episode = next(name for name, one in results.episodes.items() if one.split == split)
    read = Page(page(results, episode, settings))
    asked = [arm for arm in arms_of(settings.arms) if arm.name in settings.splits[split].arms]
    shown = [row.attributes["data-arm"] for row in read.all("tr") if "data-arm" in row.attributes]
    assert {*shown} == {arm.name for arm in asked}
    for arm in asked:
        rows = read.all("tr", data_arm=arm.name)
        assert len(rows) == (len(settings.evaluation.seeds) if arm.kind is Kind.EMBODIED else arm.runs)
        assert not any("unknown" in row.classes for row in rows), arm.name


@pytest.mark.parametrize("split", SPLITS)
def test_controls_stand_below_all_systems(released, split):
    settings, results = released
    episode = next(name for name, one in results.episodes.items() if one.split == split)
    read = Page(page(results, episode, settings))
    shown = [row.attributes["data-arm"] for row in read.all("tr") if "data-arm" in row.attributes]
    for kind in Kind:
        controls = [settings.arms[name].control for name in shown if settings.arms[name].kind is kind]
        assert any(controls) and controls == sorted(controls)


def test_letters_do_not_run_out():
    names = [letters(number) for number in range(1000)]
    assert len({*names}) == 1000
    assert (names[0], names[25], names[26], names[27], names[52], names[702]) == ("A", "Z", "AA", "AB", "BA", "AAA")


def test_few_arms_are_drawn_at_first_and_every_arm_can_be(released):
    settings, results = released
    read = Page(page(results, next(iter(results.episodes)), settings))
    first = {*shown_at_first(settings)}
    assert {settings.comparisons.agent} < first and len(first) == 4
    boxes = {box.attributes["id"].removeprefix("arm-"): box for box in read.all("input", type="checkbox")}
    for arm in arms_of(settings.arms):
        (drawn,) = read.of_class(f"arm-{arm.name}")
        assert drawn.name == "g" and ("checked" in boxes[arm.name].attributes) == (arm.name in first)
        for row in read.all("tr", data_arm=arm.name):
            above = row.parent
            while above is not None and above.name != "details":
                above = above.parent
            assert (above is None) == (arm.name in first)


def test_a_split_that_no_arm_answered_names_its_own_command(released):
    settings, results = released
    episode = next(name for name, one in results.episodes.items() if one.split == "dev")
    words = Page(page(results, episode, settings)).all("main")[0].text
    assert "results/splits/dev" in words and "make tables" not in words
