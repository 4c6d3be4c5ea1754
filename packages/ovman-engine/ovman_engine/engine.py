"""The engine: a world, a camera on it, and the state that a client's actions go by."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from random import Random
from typing import TYPE_CHECKING, Any

import msgpack

from ovman_engine import MASKS_ONLY
from ovman_engine.bodies.embodiment import DEFAULT
from ovman_engine.client import event
from ovman_engine.client.event import Outcome, thrown
from ovman_engine.client.request import Unintelligible, decoded, sequence_id
from ovman_engine.client.settings import Images, Settings
from ovman_engine.client.wire import Field

if TYPE_CHECKING:
    import numpy as np

    from ovman_engine.client.metadata import SceneMetadata
    from ovman_engine.picture.camera import Onlooker, Renderer, View
    from ovman_engine.picture.map_view import MapView
    from ovman_engine.picture.third_party import ThirdPartyCamera
    from ovman_engine.plan.floorplan import FloorPlan
    from ovman_engine.sight.visibility import Sight
    from ovman_engine.world.world import World

ACTION_S = 0.1
"""Simulated time that an action takes while physics runs by itself. AI2-THOR's actions take as long as the frames that Unity
draws for them; a tenth of a second lets a dropped thing fall and come to rest within the few actions that AI2-THOR needs."""
SCENES_KEPT = 3
"""Floor plans kept for the next Reset to them; what is drawn of a plan is kept with it."""
SCENE_SUFFIX = "_physics"
"""What AI2-THOR appends to the names of the iTHOR scenes."""
PROCEDURAL = "Procedural"
"""The scene that houses are put into."""


@lru_cache(maxsize=SCENES_KEPT)
def _plan(name: str) -> FloorPlan:
    from ovman_engine.plan import floorplan

    if name == PROCEDURAL:
        from ovman_engine.plan import house, houseplan

        return houseplan.plan_of(house.empty())
    return floorplan.read(name)


class Engine:
    """Answers one client, action by action. Imports the world when the first scene is asked for and the camera with the first
    image, so that a client has its first event at once."""

    def __init__(self, width: int = 300, height: int = 300, draws: bool = True) -> None:
        """Pictures of `width` x `height` pixels; none at all unless it `draws`."""
        self.width, self.height, self._draws = width, height, draws
        self.settings = Settings()
        self.scene_name = ""
        self.cameras: tuple[ThirdPartyCamera, ...] = ()
        self.map_view: MapView | None = None
        self.auto_simulation = True
        self.seed = 0
        self.random = Random(0)
        """What the noise of motions is drawn from; SetRandomSeed starts it anew."""
        self.draws = 0
        self.time_s = 0.0
        self._world: World | None = None
        self._absence = "send the action Reset with a sceneName first."
        self._metadata: SceneMetadata | None = None
        self._renderer: Renderer | None = None
        self._last_state: tuple[Any, ...] | None = None
        self._last_images = Images()
        self._sequence: Any = 0
        self._resets = 0

    # What actions use

    @property
    def world(self) -> World:
        """Refused while no scene is loaded."""
        if self._world is None:
            from ovman_engine.world.world import Refused

            raise Refused(f"No scene is loaded: {self._absence}")
        return self._world

    @property
    def sight(self) -> Sight:
        """The agent's sight of the world as it is now. Refused while no scene is loaded."""
        _ = self.world
        return self._metadata.sight

    @property
    def agent_mode(self) -> str:
        """agentMode of the agent, by which actions are chosen; the default one while no scene is loaded."""
        return DEFAULT.mode if self._world is None else self._world.agent.embodiment.mode

    def load(self, scene_name: str) -> None:
        """A fresh world of the scene ("FloorPlan201_physics"), settings as before any Initialize. KeyError if there is none."""
        from ovman_engine.client.metadata import SceneMetadata
        from ovman_engine.world.world import World

        try:
            plan = _plan(scene_name.removesuffix(SCENE_SUFFIX))
        except Exception as error:
            self._absence = f"{type(error).__name__}: {error}"
            raise
        world = World(plan, seed=self.seed)
        self._resets += 1
        self._world, self._metadata, self._renderer = world, SceneMetadata(world), None
        self.scene_name = scene_name
        self.cameras = ()
        self.map_view = None
        self.settings = Settings()
        self.auto_simulation = True
        self.time_s = 0.0

    def furnish(self, plan: FloorPlan) -> None:
        """A fresh world of `plan` in the scene as it is: settings, cameras and the kind of agent stay."""
        from ovman_engine.client.metadata import SceneMetadata
        from ovman_engine.world.world import World

        world = World(plan, seed=self.seed)
        world.agent.embodiment = self.world.agent.embodiment
        self._resets += 1
        self._world, self._metadata, self._renderer = world, SceneMetadata(world), None
        self.map_view = None

    def change(self, **settings: Any) -> None:
        """Replaces settings by name."""
        self.settings = replace(self.settings, **settings)

    def snapped(self, position: np.ndarray) -> np.ndarray:
        """The position (3,) on the grid in x and z, if positions snap to it."""
        if not self.settings.snap_to_grid:
            return position
        import numpy as np

        grid = self.settings.grid_m
        return np.array([round(position[0] / grid) * grid, position[1], round(position[2] / grid) * grid])

    def in_bounds(self, position: np.ndarray) -> bool:
        """Whether a position (3,) is within the bounds of the scene."""
        low, high = self.world.bounds()
        return bool(((low <= position) & (position <= high)).all())

    def view(self) -> View:
        """What the agent's camera looks at."""
        from ovman_engine.picture.camera import View

        agent, s = self.world.agent, self.settings
        if self.map_view is not None:
            return self.map_view.view(self.width, self.height, s.near_m, s.far_m, self.onlooker())
        return View(
            agent.camera,
            agent.yaw_deg,
            agent.horizon_deg,
            s.field_of_view_deg,
            self.width,
            self.height,
            near_m=s.near_m,
            far_m=s.far_m,
        )

    def onlooker(self) -> Onlooker:
        """What cameras see that are not the agent's eye."""
        from ovman_engine.picture.camera import Onlooker

        return Onlooker(agent=self.settings.agent_visible, ceiling=self.map_view is None)

    # What the client sees

    def first_message(self) -> list[tuple[Field, bytes | memoryview]]:
        """The message that the client waits for before it sends anything."""
        return self._message({"action": "", "sequenceId": 0}, Outcome(), Images())

    def answer(self, body: bytes) -> list[tuple[Field, bytes | memoryview]]:
        """Does what the action in `body` (JSON) asks for and returns the frames of the reply. Never raises: a client whose engine
        falls silent waits for ever."""
        try:
            request = decoded(body)
        except Unintelligible as error:
            self._sequence = self._sequence + 1 if isinstance(self._sequence, int) else 0
            return self._message({}, Outcome(success=False, message=str(error)), Images())
        self._sequence = sequence_id(request)
        try:
            outcome = self._perform(request)
        except Exception as error:  # a package that an action needs is not installed, or physics gave up
            outcome = thrown(error)
        for images in (self._wanted(request), Images()):
            try:
                return self._message(request, outcome, images)
            except Exception as error:
                self._last_state = None
                outcome = thrown(error)
        return [(Field.METADATA, msgpack.packb(event.message(event.agent(self, {}, outcome, None, None), self._sequence)))]

    def _perform(self, request: Mapping[str, Any]) -> Outcome:
        from ovman_engine.actions import dispatch

        outcome = dispatch.perform(self, request)
        if self._world is None:
            return outcome
        self.time_s += ACTION_S
        if self.auto_simulation and not self._world.at_rest:
            self._world.advance(ACTION_S)
        return outcome

    def _wanted(self, request: Mapping[str, Any]) -> Images:
        """Reset is answered without images: the client sends Initialize before anybody sees its event. Classes never come without
        instances, because the client makes its masks of classes from those."""
        if not self._draws or self._world is None or request.get("action") == "Reset" or request.get("renderImage") is False:
            return Images()
        if request.get(MASKS_ONLY) is True:
            return Images(instances=True)
        s = self.settings

        def asked(*keys: str) -> bool:
            return any(request.get(key) is True for key in keys)

        classes = s.classes or asked("renderSemanticSegmentation", "renderClassImage")
        return Images(
            True,
            s.depth,
            s.instances or classes or asked("renderInstanceSegmentation", "renderObjectImage"),
            classes,
            s.normals or asked("renderNormalsImage"),
        )

    def _message(self, request: Mapping[str, Any], outcome: Outcome, wanted: Images) -> list[tuple[Field, bytes | memoryview]]:
        state = self._state()
        if self.settings.fast_emit and state is not None and state == self._last_state and wanted == self._last_images:
            return [(Field.METADATA_PATCH, msgpack.packb(event.patch(request, outcome, self.time_s)))]
        images: list[tuple[Field, memoryview]] = []
        colours = None
        if wanted.any:
            images, colours = self._draw(wanted)
        agent = event.agent(self, request, outcome, self._metadata, colours)
        self._last_state, self._last_images = state, wanted
        return [(Field.METADATA, msgpack.packb(event.message(agent, self._sequence))), *images]

    def _state(self) -> tuple[Any, ...] | None:
        """Equal for two events only if they show the same world in the same way; None while there is no world, or it moves."""
        world = self._world
        if world is None or not world.at_rest:
            return None
        agent = world.agent
        pose = (*agent.position.tolist(), agent.yaw_deg, agent.horizon_deg, agent.standing, agent.embodiment)
        return (self._resets, world.version, pose, self.settings, self.width, self.height, self.cameras, self.map_view)

    def _draw(self, wanted: Images) -> tuple[list[tuple[Field, memoryview]], list[dict[str, Any]] | None]:
        from ovman_engine.client.images import AGENT, THIRD_PARTY, colour_table, encoded
        from ovman_engine.picture.camera import Renderer

        if self._renderer is None:
            self._renderer = Renderer(self.world)
        self._renderer.decor = self.settings.decor
        ids = wanted.instances or wanted.classes
        names = self._renderer.names
        images = []
        third_party = [(camera.view(self.width, self.height, self.onlooker()), THIRD_PARTY) for camera in self.cameras]
        for view, fields in [(self.view(), AGENT), *third_party]:
            frame = self._renderer.frame(view, rgb=wanted.colour, depth=wanted.depth, ids=ids, normals=wanted.normals)
            images += encoded(frame, names, view, wanted, fields)
        return images, colour_table(names) if ids else None
