"""Serves episodes as the released runner is documented to: one Controller, one agent, one file an episode."""

import json
import queue
from pathlib import Path

import ai2thor.controller

POSES = ("x", "y", "z")


def get_object_by_id(objects, object_id):
    return next((o for o in objects if o["objectId"] == object_id), None)


def get_object_by_type(objects, object_type):
    return next((o for o in objects if o["objectType"] == object_type), None)


def pose(event):
    agent = event.metadata["agent"]
    return {k: agent["position"][k] for k in POSES} | {"rotation": agent["rotation"]["y"], "horizon": agent["cameraHorizon"]}


class RobothorChallenge:
    @staticmethod
    def setup_env():
        raise RuntimeError("no nvidia cards found")

    @staticmethod
    def inference_worker(
        worker_ind,
        in_queue,
        out_queue,
        agent_class,
        agent_kwargs,
        controller_kwargs,
        max_steps,
        test,
        device,
        class_remap,
        experiment_name,
        no_grad,
        seed,
        env_type,
        class_type,
    ):
        RobothorChallenge.setup_env()
        assert env_type.name == "NORMAL" and str(device) == "cpu" and no_grad and not test and class_remap is None
        agent = agent_class(device=device, **agent_kwargs)
        controller = ai2thor.controller.Controller(commit_id="0" * 40, x_display="0.0", **controller_kwargs)
        controller.step(action="SetRandomSeed", seed=seed)
        while True:
            try:
                e = in_queue.get(timeout=1)
            except queue.Empty:
                break
            controller.initialization_parameters["robothorChallengeEpisodeId"] = e["id"]
            controller.reset(e["scene"])
            controller.step(action="SetRandomSeed", seed=seed)
            start = {
                "action": "TeleportFull",
                **e["initial_position"],
                "rotation": {"x": 0, "y": e["initial_orientation"], "z": 0},
            }
            controller.step("SetObjectFilter", objectIds=[e["object_id"]])
            controller.step(action=start | {"horizon": 0, "standing": True})
            agent.reset()
            trajectory, taken, seen, stopped = [pose(controller.last_event)], [], False, False
            while len(taken) < max_steps and not stopped:
                event = controller.last_event
                action = agent.act({"object_goal": e["object_type"], "rgb": event.frame, "depth": event.depth_frame})
                event = controller.step(action=action)
                target = get_object_by_id(event.metadata["objects"], e["object_id"])
                assert target is not None
                stopped, seen = action == "Stop", seen or target["visible"]
                taken.append({"action": action, "success": event.metadata["lastActionSuccess"]})
                trajectory.append(pose(event))
            success = stopped and bool(target["visible"])
            metrics = {"trajectory": trajectory, "actions_taken": taken, "success": success, "vision_error_in_case_of_fail": seen}
            result = {"path": trajectory, "shortest_path": e["shortest_path"], "success": success}
            record = {"episode_metrics": metrics, "episode_result": result}
            Path(experiment_name, f"{e['id']}.json").write_text(json.dumps(record))
            controller.step("ResetObjectFilter")
            out_queue.put((e["id"], metrics, result))
        controller.stop()
