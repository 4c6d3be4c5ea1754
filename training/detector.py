"""Train the class-agnostic detector with ultralytics' own trainer, from random or from given weights."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ovman.perception import networks
from ovman.perception.detector import Detector
from ovman.perception.labels import LEAST_IOU
from ovman.settings import Settings
from training.crops import match_detections
from training.pictures import list_pictures

WARM_UP_EPOCHS, FURTHER_WARM_UP_EPOCHS = 0.25, 0.05
FINAL_RATE = 0.01
"""Final learning rate as a share of the peak."""
AUGMENTATION = {
    "hsv_h": 0.03,
    "hsv_s": 0.5,
    "hsv_v": 0.4,
    "degrees": 0.0,
    "translate": 0.1,
    "scale": 0.4,
    "fliplr": 0.5,
    "mosaic": 0.5,
    "erasing": 0.0,
}
"""Augmentation by ultralytics' names."""


@dataclass(frozen=True, slots=True)
class MatchCounts:
    """Counts over pictures: true instances, recalled ones among them, detections, and right ones among them."""

    true: int = 0
    recalled: int = 0
    found: int = 0
    right: int = 0

    def __add__(self, other: MatchCounts) -> MatchCounts:
        return MatchCounts(
            self.true + other.true, self.recalled + other.recalled, self.found + other.found, self.right + other.right
        )

    @property
    def recall(self) -> float:
        """recalled / true; NaN without true instances."""
        return self.recalled / self.true if self.true else float("nan")

    @property
    def precision(self) -> float:
        """right / found; NaN without detections."""
        return self.right / self.found if self.found else float("nan")


def count_matches(iou: np.ndarray, sizes: np.ndarray, min_mask_px: int) -> MatchCounts:
    """Count for IoU (N, K): a true instance has at least `min_mask_px` pixels; a detection of a smaller one is right, too."""
    true = sizes >= min_mask_px
    recalled = iou.max(axis=0, initial=0.0) >= LEAST_IOU
    right = iou.max(axis=1, initial=0.0) >= LEAST_IOU
    return MatchCounts(int(true.sum()), int((true & recalled).sum()), len(iou), int(right.sum()))


def evaluate(detector: Detector, folders: Sequence[Path], min_mask_px: int, every: int = 1) -> MatchCounts:
    """Compare a detector with the true masks of recorded pictures: masks of at least `min_mask_px`, IoU at least 0.5."""
    total = MatchCounts()
    for _, _, iou, sizes in match_detections(detector, list_pictures(folders, every), min_mask_px):
        total += count_matches(iou, sizes, min_mask_px)
    return total


def run(
    taught: Sequence[Path],
    held_out: Sequence[Path],
    settings: Settings,
    start: Path | None,
    work: Path,
    weights: Path,
    curve: Path,
) -> None:
    """Train on the recorded scenes `taught`; from the weights `start`, if given, and then without mosaics.

    `held_out` are for evaluation only. Writes weights (.safetensors, half precision) and the curve (JSON lines).
    """
    import torch
    import ultralytics
    from safetensors.torch import load_file

    from training.trainer import Trainer

    torch.set_num_threads(1)
    library: Any = ultralytics  # which has no types
    library.settings.update({"sync": False})
    training = settings.training.detector
    epochs, rate = (
        (training.epochs, training.learning_rate) if start is None else (training.further_epochs, training.further_learning_rate)
    )
    perception = settings.perception
    work.mkdir(parents=True, exist_ok=True)
    data = work / "data.yaml"
    lists = {"train": taught, "val": held_out}
    for name, folders in lists.items():
        (work / f"{name}.txt").write_text("".join(f"{one.image.resolve()}\n" for one in list_pictures(folders)))
    data.write_text(f"path: {work.resolve()}\ntrain: train.txt\nval: val.txt\nnames:\n  0: object\n")
    trainer: Any = Trainer(
        overrides={
            "model": f"{perception.detector.architecture}.yaml",
            "pretrained": False,
            "data": str(data),
            "imgsz": perception.detector.side_px,
            "epochs": epochs,
            "batch": training.batch,
            "nbs": training.batch,
            "workers": 1,
            "cache": False,
            "device": "cuda" if torch.cuda.is_available() else "cpu",
            "amp": False,
            "optimizer": "AdamW",
            "lr0": rate,
            "lrf": FINAL_RATE,
            "warmup_epochs": WARM_UP_EPOCHS if start is None else FURTHER_WARM_UP_EPOCHS,
            "warmup_bias_lr": 0.0,
            "weight_decay": training.weight_decay,
            "seed": settings.training.seed,
            "deterministic": True,
            "single_cls": True,
            "val": False,
            "plots": False,
            "project": str(work.resolve()),
            "name": "ultralytics",
            "exist_ok": True,
            **AUGMENTATION,
            "close_mosaic": 1 if start is None else epochs,
        },
        start=None if start is None else load_file(start),
    )
    watch = _Watch(held_out, settings, rate, weights, curve)
    trainer.add_callback("on_train_batch_start", watch.set_rate)
    trainer.add_callback("on_train_batch_end", watch.evaluate)
    trainer.train()
    watch.evaluate(trainer, last=True)


class _Watch:
    """Sets the learning rate of every step and evaluates on the held-out scenes."""

    def __init__(self, held_out: Sequence[Path], settings: Settings, rate: float, weights: Path, curve: Path) -> None:
        self._held_out, self._settings, self._weights, self._curve = held_out, settings, weights, curve
        self._rate = rate
        self._step, self._began = 0, time.monotonic()
        curve.write_text("")

    def set_rate(self, trainer: Any) -> None:
        """Follow a cosine schedule over steps. The trainer's own schedule changes per epoch, and a training has few epochs."""
        whole = trainer.epochs * len(trainer.train_loader)
        cosine = 0.5 * (1 + math.cos(math.pi * min(self._step / whole, 1.0)))
        for group in trainer.optimizer.param_groups:
            group["lr"] = self._rate * (FINAL_RATE + (1 - FINAL_RATE) * cosine)

    def evaluate(self, trainer: Any, last: bool = False) -> None:
        """Write weights and rates every `look_every` steps, so that an interrupted training leaves a result."""
        from safetensors.torch import save_file

        self._step += not last
        training = self._settings.training.detector
        if not last and self._step % training.look_every:
            return
        state = {name: value.half().contiguous() for name, value in trainer.ema.ema.state_dict().items()}
        save_file(state, self._weights)
        perception = self._settings.perception.detector
        average, seen_at = trainer.ema.ema, (perception.side_px, perception.confidence)
        detector = networks.loaded_detector(average, *seen_at, str(trainer.device))
        total = evaluate(detector, self._held_out, perception.min_mask_px, 1 if last else training.look_at_one_in)
        losses = {} if trainer.tloss is None else {name: round(float(value), 4) for name, value in trainer.tloss.items()}
        record = {
            "step": self._step,
            "minutes": round((time.monotonic() - self._began) / 60, 1),
            "loss": losses,
            "recall": round(total.recall, 4),
            "precision": round(total.precision, 4),
        }
        line = json.dumps(record)
        with self._curve.open("a", encoding="utf-8") as file:
            file.write(line + "\n")
        print(line, flush=True)
