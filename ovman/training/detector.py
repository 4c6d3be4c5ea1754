"""Stage `detector`: trains the class-agnostic detector with ultralytics' own trainer, from random weights."""

from __future__ import annotations

import json
import math
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from ovman.perception import networks
from ovman.perception.detector import Detector
from ovman.perception.overlap import Found, found
from ovman.settings import Settings
from ovman.training.picture_files import recorded
from ovman.training.seen import seen

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


def judged(detector: Detector, folders: Sequence[Path], min_mask_px: int, every: int = 1) -> Found:
    """Recall and precision of a detector on recorded pictures: masks of at least `min_mask_px`, IoU at least 0.5."""
    total = Found()
    for _, _, iou, sizes in seen(detector, recorded(folders, every), min_mask_px):
        total += found(iou, sizes, min_mask_px)
    return total


def run(
    taught: Sequence[Path],
    held_out: Sequence[Path],
    constants: Settings,
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

    from ovman.training.half import HalfTrainer

    torch.set_num_threads(1)
    made: Any = ultralytics  # which has no types
    made.settings.update({"sync": False})
    settings = constants.training.detector
    epochs, rate = (
        (settings.epochs, settings.learning_rate) if start is None else (settings.further_epochs, settings.further_learning_rate)
    )
    perception = constants.perception
    work.mkdir(parents=True, exist_ok=True)
    data = work / "data.yaml"
    lists = {"train": taught, "val": held_out}
    for name, folders in lists.items():
        (work / f"{name}.txt").write_text("".join(f"{one.image.resolve()}\n" for one in recorded(folders)))
    data.write_text(f"path: {work.resolve()}\ntrain: train.txt\nval: val.txt\nnames:\n  0: object\n")
    trainer: Any = HalfTrainer(
        overrides={
            "model": f"{perception.detector.architecture}.yaml",
            "pretrained": False,
            "data": str(data),
            "imgsz": perception.detector.side_px,
            "epochs": epochs,
            "batch": settings.batch,
            "nbs": settings.batch,
            "workers": 1,
            "cache": False,
            "device": "cuda" if torch.cuda.is_available() else "cpu",
            "amp": False,
            "optimizer": "AdamW",
            "lr0": rate,
            "lrf": FINAL_RATE,
            "warmup_epochs": WARM_UP_EPOCHS if start is None else FURTHER_WARM_UP_EPOCHS,
            "warmup_bias_lr": 0.0,
            "weight_decay": settings.weight_decay,
            "seed": constants.training.seed,
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
    watch = _Watch(held_out, constants, rate, weights, curve)
    trainer.add_callback("on_train_batch_start", watch.rate)
    trainer.add_callback("on_train_batch_end", watch.look)
    trainer.train()
    watch.look(trainer, last=True)


class _Watch:
    """Sets the learning rate of every step and evaluates on the held-out scenes."""

    def __init__(self, held_out: Sequence[Path], constants: Settings, rate: float, weights: Path, curve: Path) -> None:
        self._held_out, self._constants, self._weights, self._curve = held_out, constants, weights, curve
        self._rate = rate
        self._step, self._began = 0, time.monotonic()
        curve.write_text("")

    def rate(self, trainer: Any) -> None:
        """A cosine schedule over steps. The trainer's own schedule changes per epoch, and a training has few epochs."""
        whole = trainer.epochs * len(trainer.train_loader)
        cosine = 0.5 * (1 + math.cos(math.pi * min(self._step / whole, 1.0)))
        for group in trainer.optimizer.param_groups:
            group["lr"] = self._rate * (FINAL_RATE + (1 - FINAL_RATE) * cosine)

    def look(self, trainer: Any, last: bool = False) -> None:
        """Every `look_every` steps write weights and rates, so that an interrupted training leaves a result."""
        from safetensors.torch import save_file

        self._step += not last
        settings = self._constants.training.detector
        if not last and self._step % settings.look_every:
            return
        state = {name: value.half().contiguous() for name, value in trainer.ema.ema.state_dict().items()}
        save_file(state, self._weights)
        perception = self._constants.perception.detector
        average, seen_at = trainer.ema.ema, (perception.side_px, perception.confidence)
        detector = networks.loaded_detector(average, self._weights, *seen_at, str(trainer.device))
        total = judged(detector, self._held_out, perception.min_mask_px, 1 if last else settings.look_at_one_in)
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
