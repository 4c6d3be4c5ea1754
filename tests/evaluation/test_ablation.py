"""Variants of an episode: its scripted change with some of its split's settings, recorded in the real engine."""

from __future__ import annotations

import math
from functools import partial

import pytest

from ovman.evaluation.ablation import make_variant, nearest_free, record_tours, write_variants
from ovman.evaluation.tours import record_tour
from ovman.records.episode import VARIANTS, Episode, Setting
from ovman.records.record import lines
from ovman.records.scene import Change
from ovman.records.task import Relation
from ovman.records.tour import Light, Sensors, Tour
from ovman.records.visit import Visit, VisitManifest, VisitPair
from ovman.sim.session import Session, SimulatorError
from tests.arms import CONFIG
from tests.episodes import DATA, EPISODES, scene_record

SCENE = "FloorPlan16"
ALL = frozenset(Setting)


@pytest.fixture(scope="module")
def plain() -> Episode:
    """A released episode as the paper has it."""
    return next(one for one in Episode.load(EPISODES) if one.scene == SCENE and one.relation is Relation.REMOVED)


@pytest.fixture(scope="module")
def full(plain) -> Episode:
    """The same with every setting: another instance is taken, and the second tour has a yaw, a light and sensors of its own."""
    scene = scene_record(SCENE)
    taken = next(o for o in scene.objects if o.moveable and o.category != plain.category)
    other = Change(
        instance=taken.id,
        category=taken.category,
        kind="disable",
        before=taken.position,
        after=None,
        path=None,
        placement=None,
        height_m=None,
        roam=None,
    )
    first = plain.tours.first.model_copy(update={"sensors": Sensors(errors=CONFIG.sensors.good, seed=1)})
    second = first.model_copy(
        update={
            "first_yaw_deg": 20.0,
            "light": Light(brightness=0.7, hue=0.1, saturation=0.2),
            "sensors": Sensors(errors=CONFIG.sensors.good, seed=2),
        }
    )
    return plain.model_copy(update={"changes": (*plain.changes, other), "tours": VisitPair[Tour](first=first, second=second)})


def test_without_any_setting_it_is_the_paper_s_episode(plain, full):
    assert make_variant(full, frozenset()) == plain


@pytest.mark.parametrize("setting", Setting)
def test_a_setting_alone_is_what_it_is_and_no_more(plain, full, setting):
    alone = make_variant(full, {setting})
    differs = {
        Setting.OTHERS: alone.others != (),
        Setting.SECOND_TOUR: alone.tours.second.first_yaw_deg == 20.0,
        Setting.LIGHT: alone.tours.second.light is not None,
        Setting.SENSORS: None not in (alone.tours.first.sensors, alone.tours.second.sensors),
    }
    assert [one for one, holds in differs.items() if holds] == [setting]
    assert alone.tours.first.light is None and alone.visits.second != plain.visits.second
    kept = ("id", "scene", "query", "sentence", "target", "answer", "spawn", "world_1", "world_2", "protocol")
    assert all(getattr(alone, name) == getattr(full, name) for name in kept)


def test_a_variant_of_a_variant_keeps_what_both_keep(full):
    for one in VARIANTS.values():
        for other in VARIANTS.values():
            assert make_variant(make_variant(full, one), other) == make_variant(full, one & other)


def test_every_variant_is_recorded_once_and_kept(full, tmp_path):
    source = tmp_path / "episodes.jsonl"
    source.write_text(lines([full]))
    files = {name: tmp_path / f"{name}.jsonl" for name in VARIANTS}
    write_variants(source, files)
    settings = CONFIG.partial({"measurement.min_mask_px": 50, "benchmark.backend": "embedded"})
    manifest = tmp_path / "visits.jsonl"
    record_tours(settings, [*files.values()], tmp_path / "visits", manifest)
    (made,) = VisitManifest.read(manifest)
    wanted = {name for file in files.values() for one in Episode.load(file) for name in (one.visits.first, one.visits.second)}
    assert {*made.visits} == wanted == {path.name for path in (tmp_path / "visits" / SCENE).iterdir()}
    taken = full.others[0].instance
    for name, file in files.items():
        (episode,) = Episode.load(file)
        seen = Visit.load(tmp_path / "visits" / SCENE / episode.visits.second)
        assert (taken in seen.present) == (name not in ("others", "all"))
        assert (seen.views[0].sensed is not None) == (name in ("sensors", "all"))
    stamps = {path: path.stat().st_mtime_ns for path in (tmp_path / "visits").rglob("*.png")}
    record_tours(settings, [*files.values()], tmp_path / "visits", manifest)
    assert {path: path.stat().st_mtime_ns for path in (tmp_path / "visits").rglob("*.png")} == stamps


def test_a_waypoint_on_which_a_thing_now_stands_gives_way(tmp_path):
    everyday = Episode.load(DATA / "episodes" / "everyday.jsonl")
    plain = make_variant(next(one for one in everyday if one.id == "FloorPlan215/former/everyday-0011"), frozenset())
    with Session(plain.scene, plain.settings) as session:
        with pytest.raises(SimulatorError, match="Collided with"):
            record_tour(session, plain, "second", tmp_path)
        made = record_tour(session, plain, "second", tmp_path, place_view=partial(nearest_free, session))
    planned = plain.tours.second.poses
    assert len(made.views) == len(planned)
    ways = [math.dist((view.pose.x, view.pose.z), (pose.x, pose.z)) for view, pose in zip(made.views, planned, strict=True)]
    assert [view.pose.yaw_deg for view in made.views] == [pose.yaw_deg for pose in planned]
    assert 0 < sum(way > 0 for way in ways) < len(ways) and max(ways) < 1.5
