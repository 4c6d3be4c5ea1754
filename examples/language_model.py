"""Ask a language model where to go: an agent that writes down what both tours showed and lets a model choose the place.

Any server of OpenAI's chat completions with tools will do, remote or local (vLLM, llama.cpp, Ollama, LM Studio):

    export OPENAI_BASE_URL=http://localhost:11434/v1 OPENAI_MODEL=qwen3:8b   # and OPENAI_API_KEY, if the server wants a key
    ovman serve --agent language_model:LanguageModel --needs maps detections --path examples
    ovman eval --server 'ws://127.0.0.1:8765/?token=TOKEN' --name language_model --split dev_everyday --seeds 0 --out mine

The second command prints the address for the third, which runs in another terminal. An isolated agent has no network and gets few
environment variables, so `ovman eval --agent` cannot run this agent. `ovman serve` runs it as your own process, not isolated
(docs/protocol.md, docs/security.md). For a first try, name one home with `--scenes`. `--track words` sends words alone.

Cost: some 4,300 tokens per query (request body in characters / 4, a home of everyday), and about 30 in the answer.
Equal requests are sent once per process, so more seeds cost nothing more. Temperature is 0 and the seed is fixed, yet a remote
model may answer differently tomorrow: its scores cannot be reproduced. After a failed request, or an answer that names no place,
the agent asks once more; then it abstains and says why in one line on standard error.
"""

import json
import math
import os
import sys
from functools import cache
from http.client import HTTPException
from urllib.error import HTTPError
from urllib.request import Request, urlopen

import numpy as np

from ovman.agents.interface import Abstention, AbstentionReason, Answer, Query
from ovman.agents.joint import Joint
from ovman.agents.joint.segments import grid_frames, vote
from ovman.agents.pilot import GoalAgent
from ovman.language import noun
from ovman.language.vocabulary import SYNONYMS

URL, MODEL = os.environ.get("OPENAI_BASE_URL"), os.environ.get("OPENAI_MODEL")
if not URL or not MODEL:
    raise ValueError("set OPENAI_BASE_URL and OPENAI_MODEL, such as http://localhost:11434/v1 and qwen3:8b")
KEY, TIMEOUT_S = os.environ.get("OPENAI_API_KEY", "none"), float(os.environ.get("OPENAI_TIMEOUT", "60"))
SETTINGS = {"temperature": 0, "seed": 0}  # leave out what your server refuses
CONSTANTS = Joint()
NOUNS = tuple(dict.fromkeys(noun(category) for category in SYNONYMS))
COLOURS = {"black": (25, 25, 25), "grey": (128, 128, 128), "white": (235, 235, 235), "red": (180, 45, 45), "blue": (55, 85, 165)}
COLOURS |= {"orange": (225, 130, 45), "brown": (110, 70, 40), "beige": (205, 180, 145), "yellow": (225, 205, 70)}
COLOURS |= {"green": (65, 125, 65), "purple": (115, 65, 130), "pink": (220, 150, 160)}  # RGB
PROMPT = """You guide a robot that toured a home twice. Between the tours people moved things, took some away and brought others.
Some things may move during the second tour. Each line is an object that one tour showed:
names: guesses of what it is, with probabilities; x, z: its place on the floor, metres; size: along x, up and along z, metres;
colour; views: how many pictures show it; last_view: the last of them;
gone: the share of it that the other tour saw through (1: it is not there in the other tour, 0: it is, null: not looked at);
moving: the share of it that other pictures of its own tour saw through.
An object that was moved is in both lists, at different places. Places in the past are those of visit 1.
Call one tool, once: the robot goes to where that object was in that visit, or to that place."""


def describe_tool(name, description, **parameters):
    """Return a tool whose parameters are all needed."""
    schema = {"type": "object", "properties": parameters, "required": [*parameters], "additionalProperties": False}
    return {"type": "function", "function": {"name": name, "description": description, "parameters": schema}}


TOOLS = [
    describe_tool("go_to", "Go to a listed object.", visit={"type": "integer", "enum": [1, 2]}, object={"type": "integer"}),
    describe_tool("go_to_place", "Go to any place, in metres.", x={"type": "number"}, z={"type": "number"}),
]


class LanguageModel(GoalAgent):
    """List the objects of both tours, ask the model for a place, and drive there."""

    def revisit(self, visit):
        """List the objects of both tours."""
        super().revisit(visit)
        first, second = grid_frames(self.first, CONSTANTS), grid_frames(visit, CONSTANTS)
        nouns = np.stack([self.context.noun(phrase) for phrase in NOUNS])
        self.objects = list_objects(1, self.first, first, second, self.context, nouns)
        self.objects += list_objects(2, visit, second, first, self.context, nouns)

    def ask(self, query):
        """Ask the model, which reads the sentence itself, once more after a bad answer; abstain after the second."""
        self.context.pilot.set_out(self.second.reachable, getattr(query, "relation", None))
        self.goal, said = Abstention(AbstentionReason.UNSURE), ""
        known = f"relation: {query.relation}, " if isinstance(query, Query) else ""  # not in the words track
        lines = [PROMPT, "", f"Task: {query.sentence.rstrip('.')}.", f"{known}noun: {query.phrase}"]
        lines += [json.dumps(one, separators=(",", ":")) for one in self.objects]
        places = tuple((one["visit"], one["object"], one["x"], one["z"]) for one in self.objects)
        for _ in range(2):
            try:
                self.goal = ask_model("\n".join([*lines, said]), places)
                return
            except (OSError, HTTPException, ArithmeticError, LookupError, TypeError, ValueError) as error:
                said = f"Your last answer was of no use: {type(error).__name__}: {' '.join(str(error).split())[:200]}"
        print(f"language_model: {query.sentence}: abstains after two tries. {said}", file=sys.stderr, flush=True)


@cache
def ask_model(prompt, places):
    """Return the place that the model names, or raise one of many errors. places: visit, object, x and z of each object."""
    message = {"role": "user", "content": prompt}
    body = {"model": MODEL, "messages": [message], "tools": TOOLS, "tool_choice": "required", **SETTINGS}
    headers = {"Content-Type": "application/json", "Authorization": f"Bearer {KEY}"}
    request = Request(f"{URL.rstrip('/')}/chat/completions", json.dumps(body).encode(), headers)
    try:
        with urlopen(request, timeout=TIMEOUT_S) as reply:
            answer = json.load(reply)
    except HTTPError as error:
        raise ValueError(f"HTTP {error.code}: {error.read().decode(errors='replace')}") from None
    call = answer["choices"][0]["message"]["tool_calls"][0]["function"]
    given = json.loads(call["arguments"])
    if call["name"] == "go_to":
        x, z = {(visit, number): (x, z) for visit, number, x, z in places}[int(given["visit"]), int(given["object"])]
    else:
        x, z = float(given["x"]), float(given["z"])
    if not (math.isfinite(x) and math.isfinite(z)):
        raise ValueError(f"({x}, {z}) is not a place")
    return Answer(x, z)


def list_objects(number, visit, frames, other_frames, context, nouns):
    """Return the objects of a visit's map, as the model gets them. frames: Of its tour and of the other one."""
    detected, listed = context.detections(visit), []
    masks = detected.masks()
    for cluster in context.mapper(visit):
        points, colours = [], []
        for k in cluster.members:
            view = detected.view[k]
            frame = frames[view]
            seen = masks[k][frame.rows[:, None], frame.columns] & frame.known
            points.append(frame.points[seen])
            colours.append(visit.observations[view].rgb[frame.rows[:, None], frame.columns][seen])
        points = np.concatenate(points)
        if not len(points):
            continue
        scores = np.exp(nouns @ cluster.feature / CONSTANTS.temperature)
        names = {NOUNS[k]: round(float(scores[k] / scores.sum()), 2) for k in np.argsort(-scores)[:3]}
        (low, high), colour = np.percentile(points, [5, 95], axis=0), np.median(np.concatenate(colours), axis=0)
        one = {"visit": number, "object": len(listed) + 1, "names": names}
        one |= {"x": round(float(cluster.position[0]), 2), "z": round(float(cluster.position[1]), 2)}
        one |= {"size": (high - low).round(1).tolist(), "colour": min(COLOURS, key=lambda name: math.dist(COLOURS[name], colour))}
        one |= {"views": len({*cluster.views.tolist()}), "last_view": cluster.last_seen}
        listed.append(one | {"gone": see_through(points, other_frames), "moving": see_through(points, frames)})
    return listed


def see_through(points, frames):
    """Return the share of points (N, 3) that frames see through, of those that they see at all; None if they see none."""
    through, at = vote(points, frames, CONSTANTS)
    seen = through + at > 0
    return round(float((through > at)[seen].mean()), 2) if seen.any() else None
