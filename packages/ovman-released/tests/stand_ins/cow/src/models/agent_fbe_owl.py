"""An agent that follows a script: it turns to its goal's number of letters, drives on, and stops. It says what it is asked."""

from pathlib import Path

import numpy as np

from ..shared.utils import ClassTypes, EnvTypes
from .localization.clip_owl import ClipOwl


class Agent:
    def __init__(self, threshold, prompts_path, classes, classes_clip, center_only, fail_stop, device):
        assert str(device) == "cpu"
        assert threshold == 0.125 and center_only and fail_stop and Path(prompts_path).is_file()
        self.clip_module = ClipOwl(classes, classes_clip)
        self.episodes = 0

    def reset(self):
        self.episodes, self.steps = self.episodes + 1, 0

    def act(self, obs):
        assert obs["rgb"].dtype == np.uint8 and obs["rgb"].shape[0] == obs["rgb"].shape[1] and obs["rgb"].shape[2] == 3
        assert obs["depth"].dtype == np.float32 and obs["depth"].shape == obs["rgb"].shape[:2]
        if self.steps == 0:
            print(f"episode {self.episodes}: {self.clip_module.forward(obs['object_goal'])}", flush=True)
        self.steps += 1
        if self.episodes == 2:
            return "RotateLeft"
        return ("RotateLeft", "MoveAhead", "MoveAhead", "Stop")[self.steps - 1]


def build(
    fail_stop,
    prompts_path,
    threshold,
    open_clip_checkpoint="",
    alpha=0.0,
    clip_model_name="ViT-B/32",
    device_num=-1,
    debug_dir=None,
    wandb_log=False,
    env_type=EnvTypes.ROBOTHOR,
    class_type=ClassTypes.REGULAR,
    center_only=False,
):
    assert device_num == -1 and env_type is EnvTypes.NORMAL and class_type is ClassTypes.REGULAR
    released = {"classes": ["HousePlant"], "classes_clip": ["plant"]}
    kwargs = {"threshold": threshold, "prompts_path": prompts_path, "center_only": center_only, "fail_stop": fail_stop}
    return Agent, kwargs | released, True
