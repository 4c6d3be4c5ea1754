"""Asks a clone of CoW what it is and does, in the Python of its own environment, without weights: prints one JSON object.

python clone_cow.py constants ROOT | room ROOT | worker ROOT JOB RESULTS | weights ROOT CACHE
"""

from __future__ import annotations

import gzip
import json
import math
import os
import queue
import sys
from importlib import import_module
from inspect import signature
from pathlib import Path

import numpy as np

from ovman_released import cow_process, cow_shims

SIDE, CAMERA_M = 224, 0.8658
LOW, HIGH = np.array([-4.0, 0.0, -3.0]), np.array([4.0, 2.5, 3.0])
TARGET = np.array([2.6, 0.0, -2.4]), np.array([3.0, 0.9, -2.0])
"""A room of 8 x 6 m and a box in it, metres, Unity's frame, floor at 0."""
STEP_M, TURN_DEG = 0.25, 30.0


def enter(root: Path) -> None:
    cow_shims.stand_in_for_lost_modules()
    sys.path.insert(0, str(root))
    os.chdir(root)


def constants(root: Path) -> dict[str, object]:
    """Numbers that the agent's modules have names for, and the text of the thresholds."""
    enter(root)
    import_module("src.models.agent_fbe_gt")
    found: dict[str, list[float]] = {}
    for module in [m for name, m in list(sys.modules.items()) if name == "src" or name.startswith("src.")]:
        for name, value in vars(module).items():
            if name.isupper() and isinstance(value, int | float):
                found.setdefault(name, []).append(float(value))
    return {"numbers": found, "thresholds": json.loads((root / "hparams" / "robo.json").read_text())}


def hits(origin: np.ndarray, rays: np.ndarray, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Where rays (N, 3) enter and leave a box, in multiples of the rays."""
    with np.errstate(divide="ignore"):
        a, b = (low - origin) / rays, (high - origin) / rays
    return np.minimum(a, b).max(1), np.maximum(a, b).min(1)


def look(x: float, z: float, yaw_deg: float) -> tuple[np.ndarray, np.ndarray]:
    """Planar depth in metres and the target's mask from a camera that looks straight ahead, 90 degrees wide."""
    pixel = (np.arange(SIDE) + 0.5) / SIDE * 2.0 - 1.0
    right, down = np.meshgrid(pixel, pixel)
    t = math.radians(yaw_deg)
    forward, across = np.array([math.sin(t), 0.0, math.cos(t)]), np.array([math.cos(t), 0.0, -math.sin(t)])
    rays = (forward + right[..., None] * across - down[..., None] * np.array([0.0, 1.0, 0.0])).reshape(-1, 3)
    origin = np.array([x, CAMERA_M, z])
    _, wall = hits(origin, rays, LOW, HIGH)
    near, far = hits(origin, rays, *TARGET)
    seen = (near > 0) & (near < far) & (near < wall)
    return np.where(seen, near, wall).reshape(SIDE, SIDE).astype(np.float32), seen.reshape(SIDE, SIDE)


def room(root: Path) -> dict[str, object]:
    """A walk of the agent that is told where its target is."""
    enter(root)
    factory = import_module("src.models.agent_fbe_gt")
    agent_class, arguments, _ = factory.build(fail_stop=True, prompts_path=str(root / cow_process.PROMPTS), threshold=0.5)
    agent = agent_class(**arguments)
    agent.reset()
    x, z, yaw_deg, actions, told = -2.0, 1.0, 0.0, [], False
    for _ in range(250):
        depth, mask = look(x, z, yaw_deg)
        told |= bool(mask.any())
        rgb = np.zeros((SIDE, SIDE, 3), np.uint8)
        observation = {"object_goal": "Mug", "rgb": rgb, "depth": depth, "target_mask": mask.astype(np.float32)}
        actions.append(str(agent.act(observation)))
        if actions[-1] == "Stop":
            break
        yaw_deg += {"RotateLeft": -TURN_DEG, "RotateRight": TURN_DEG}.get(actions[-1], 0.0)
        if actions[-1] == "MoveAhead":
            x, z = x + STEP_M * math.sin(math.radians(yaw_deg)), z + STEP_M * math.cos(math.radians(yaw_deg))
    middle = (TARGET[0] + TARGET[1]) / 2.0
    return {"actions": actions, "told": told, "distance_m": math.hypot(x - middle[0], z - middle[2])}


class Scripted:
    """Turns once, and stops. device: the runner adds its own to what an agent is made with."""

    def __init__(self, device: object) -> None:
        self.device = device

    def reset(self) -> None:
        self.steps = 0

    def act(self, observation: dict[str, object]) -> str:
        self.steps += 1
        return ("RotateLeft", "Stop")[self.steps - 1]


def worker(root: Path, job: Path, results: Path) -> dict[str, object]:
    """The runner's own loop around a scripted agent, on the fake Controller below; a target that is not there first."""
    enter(root)
    runner = import_module(cow_process.RUNNER)
    cow_shims.start_no_display(runner)
    cow_shims.allow_absent_targets(runner)
    cow_shims.start_with(runner, Fake)
    kinds = signature(import_module("src.models.agent_fbe_gt").build).parameters
    world = {"env_type": type(kinds["env_type"].default).NORMAL, "class_type": type(kinds["class_type"].default).REGULAR}
    waiting: queue.Queue[object] = queue.Queue()
    for episode in json.loads(job.read_text()):
        waiting.put(episode)
    runner.RobothorChallenge.inference_worker(
        worker_ind=0,
        in_queue=waiting,
        out_queue=cow_process._Results(),
        agent_class=Scripted,
        agent_kwargs={},
        controller_kwargs={"width": SIDE, "height": SIDE},
        max_steps=250,
        test=False,
        device=cow_process._device("cpu"),
        class_remap=None,
        experiment_name=str(results),
        no_grad=True,
        seed=0,
        **world,
    )
    return {path.stem: json.loads(path.read_text()) for path in sorted(results.glob("*.json"))}


def weights(root: Path, cache: Path) -> dict[str, object]:
    """A small random OWL-ViT with CLIP's vocabulary, in a cache of Hugging Face, as google/owlvit-base-patch32.

    It finds nothing: its boxes are the cells of its grid and its scores far below the threshold, so that the agent explores.
    """
    import torch

    transformers = import_module("transformers")  # the clone's environment has it

    repository = cache / "hub" / "models--google--owlvit-base-patch32"
    snapshot = repository / "snapshots" / ("0" * 40)
    for directory in (snapshot, repository / "refs"):
        directory.mkdir(parents=True)
    (repository / "refs" / "main").write_text("0" * 40)
    with gzip.open(root / "src" / "clip" / "bpe_simple_vocab_16e6.txt.gz", "rt", encoding="utf-8") as file:
        merges = file.read().split("\n")[1:48895]
    shown = [*range(33, 127), *range(161, 173), *range(174, 256)]
    letters = [chr(code) for code in shown] + [chr(256 + k) for k in range(256 - len(shown))]
    words = letters + [f"{letter}</w>" for letter in letters] + [merge.replace(" ", "") for merge in merges]
    first, last = "<|startoftext|>", "<|endoftext|>"
    (snapshot / "vocab.json").write_text(json.dumps({word: k for k, word in enumerate([*words, first, last])}))
    (snapshot / "merges.txt").write_text("\n".join(["#version: 0.2", *merges, ""]))
    special = {"bos_token": first, "eos_token": last, "unk_token": last, "pad_token": "!"}
    tokenizer = special | {"tokenizer_class": "CLIPTokenizer", "model_max_length": 16, "do_lower_case": True}
    (snapshot / "tokenizer_config.json").write_text(json.dumps(tokenizer))
    pictures = {"feature_extractor_type": "OwlViTFeatureExtractor", "size": 768, "do_resize": True, "do_center_crop": False}
    (snapshot / "preprocessor_config.json").write_text(json.dumps(pictures))
    torch.manual_seed(0)
    small = {"hidden_size": 32, "intermediate_size": 64, "num_hidden_layers": 2, "num_attention_heads": 4}
    text = small | {"vocab_size": len(words) + 2, "max_position_embeddings": 16}
    vision = small | {"image_size": 768, "patch_size": 32}
    made = transformers.OwlViTForObjectDetection(
        transformers.OwlViTConfig(text_config=text, vision_config=vision, projection_dim=32)
    )
    with torch.no_grad():
        for name, values in made.named_parameters():
            if name.startswith(("box_head.dense2", "class_head.logit")):
                values.fill_(-9.0 if name == "class_head.logit_shift.bias" else 0.0)
    made.save_pretrained(snapshot)
    return {"files": sorted(path.name for path in snapshot.iterdir())}


class Event:
    """What a simulator answers: an empty room with one thing in it."""

    def __init__(self, x: float, z: float, yaw_deg: float) -> None:
        self.depth_frame, _ = look(x, z, yaw_deg)
        self.frame = np.zeros((SIDE, SIDE, 3), np.uint8)
        self.cv2img = self.frame[..., ::-1]
        position, rotation = {"x": x, "y": 0.9, "z": z}, {"x": 0.0, "y": yaw_deg % 360.0, "z": 0.0}
        thing = {"objectId": "Mug|1", "objectType": "Mug", "visible": False, "position": position, "distance": 3.0}
        self.metadata = {
            "agent": {"position": position, "rotation": rotation, "cameraHorizon": 0.0},
            "objects": [thing],
            "lastAction": "",
            "lastActionSuccess": True,
            "errorMessage": "",
            "actionReturn": None,
        }


class Fake:
    """A Controller of such a room."""

    def __init__(self, *_: object, **parameters: object) -> None:
        self.initialization_parameters = dict(parameters)
        self.last_event = Event(0.0, 0.0, 0.0)

    def reset(self, *_: object, **__: object) -> Event:
        return self.last_event

    def step(self, action: object = None, **arguments: object) -> Event:
        name = action["action"] if isinstance(action, dict) else action
        yaw_deg = self.last_event.metadata["agent"]["rotation"]["y"]
        self.last_event = Event(0.0, 0.0, yaw_deg - TURN_DEG * (name == "RotateLeft"))
        return self.last_event

    def stop(self) -> None:
        """Nothing runs."""


if __name__ == "__main__":
    ask, *places = sys.argv[1:]
    said = {"constants": constants, "room": room, "worker": worker, "weights": weights}[ask](*map(Path, places))
    print("\nOVMAN " + json.dumps(said))
