"""The state of one client's session: its scene, the settings of Initialize, and the cameras on the scene."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from random import Random
from typing import TYPE_CHECKING, Any

from ovman_engine.bodies.embodiment import DEFAULT
from ovman_engine.client.settings import Settings
from ovman_engine.world.errors import Refused

if TYPE_CHECKING:
    import numpy as np

    from ovman_engine.bodies.body import Body
    from ovman_engine.client.metadata import SceneMetadata
    from ovman_engine.picture.camera import Onlooker, View
    from ovman_engine.picture.map_view import MapView
    from ovman_engine.picture.third_party import ThirdPartyCamera
    from ovman_engine.plan.floorplan import FloorPlan
    from ovman_engine.sight.visibility import Sight
    from ovman_engine.world.world import World

SCENES_KEPT = 3
"""Floor plans kept for the next Reset to one of them. What is drawn of a floor plan is kept with it."""
SCENE_SUFFIX = "_physics"
"""What AI2-THOR appends to the names of the iTHOR scenes."""
PROCEDURAL = "Procedural"
"""The scene that CreateHouse puts houses into."""


@lru_cache(maxsize=SCENES_KEPT)
def _plan(name: str) -> FloorPlan:
    from ovman_engine.plan import floorplan

    if name == PROCEDURAL:
        from ovman_engine.plan import house, houseplan

        return houseplan.plan_of(house.empty())
    return floorplan.read(name)


class Session:
    """What the actions of one client read and change.

    The modules of the world are imported with the first scene, those of the camera with the first view: the client's first event
    needs neither and is sent at once.
    """

    def __init__(self, width: int = 300, height: int = 300) -> None:
        """No scene is loaded. Images are `width` x `height` pixels."""
        self.width, self.height = width, height
        self.settings = Settings()
        self.scene_name = ""
        self.cameras: tuple[ThirdPartyCamera, ...] = ()
        self.map_view: MapView | None = None
        self.auto_simulation = True
        self.seed = 0
        self.random = Random(0)
        """Source of the motion noise; SetRandomSeed restarts it."""
        self.draws = 0
        """Number of random materials, colours and lights drawn since SetRandomSeed."""
        self.time_s = 0.0
        self.scene: SceneMetadata | None = None
        """Metadata of the world; None while no scene is loaded"""
        self._world: World | None = None
        self._absence = "send the action Reset with a sceneName first."
        self._worlds = 0

    @property
    def loaded(self) -> bool:
        """Whether a scene is loaded."""
        return self._world is not None

    @property
    def world(self) -> World:
        """The world of the scene. Raises Refused while no scene is loaded."""
        if self._world is None:
            raise Refused(f"No scene is loaded: {self._absence}")
        return self._world

    @property
    def sight(self) -> Sight:
        """What can be seen in the world as it is now. Raises Refused while no scene is loaded."""
        if self.scene is None:
            raise Refused(f"No scene is loaded: {self._absence}")
        return self.scene.sight

    @property
    def agent_mode(self) -> str:
        """Mode of the agent, which selects among overloads of an action; the default while no scene is loaded."""
        return DEFAULT.mode if self._world is None else self._world.agent.embodiment.mode

    def body(self, object_id: str) -> Body:
        """Return the body of an object that is in the scene, enabled or not. Raises Refused for any other objectId."""
        body = self.world.bodies.get(object_id)
        if body is None or body.removed:
            raise Refused(f"Cannot find sim object with id '{object_id}'")
        return body

    def load(self, scene_name: str) -> None:
        """Load the untouched scene ("FloorPlan201_physics"), with the settings that hold before any Initialize.

        Raises KeyError if no such scene exists; the session then keeps the scene that it has.
        """
        try:
            plan = _plan(scene_name.removesuffix(SCENE_SUFFIX))
        except Exception as error:
            self._absence = f"{type(error).__name__}: {error}"
            raise
        self._enter(plan)
        self.scene_name = scene_name
        self.cameras = ()
        self.settings = Settings()
        self.auto_simulation = True
        self.time_s = 0.0

    def furnish(self, plan: FloorPlan) -> None:
        """Replace the world by that of `plan`. Settings, cameras and the kind of agent stay."""
        embodiment = self.world.agent.embodiment
        self._enter(plan)
        self.world.agent.embodiment = embodiment

    def _enter(self, plan: FloorPlan) -> None:
        from ovman_engine.client.metadata import SceneMetadata
        from ovman_engine.world.world import World

        world = World(plan, seed=self.seed)
        self._world, self.scene = world, SceneMetadata(world)
        self._worlds += 1
        self.map_view = None

    def change(self, **settings: Any) -> None:
        """Replace settings by name."""
        self.settings = replace(self.settings, **settings)

    def snapped(self, position: np.ndarray) -> np.ndarray:
        """Return the position (3,) metres, rounded to the grid in x and z if positions snap to it."""
        if not self.settings.snap_to_grid:
            return position
        import numpy as np

        grid = self.settings.grid_m
        return np.array([round(position[0] / grid) * grid, position[1], round(position[2] / grid) * grid])

    def in_bounds(self, position: np.ndarray) -> bool:
        """Whether a position (3,) metres is within the bounds of the scene."""
        low, high = self.world.bounds()
        return bool(((low <= position) & (position <= high)).all())

    def view(self) -> View:
        """Return the view of the agent's camera, or of the map while that is shown."""
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
        """Return what cameras other than the agent's own show besides the scene."""
        from ovman_engine.picture.camera import Onlooker

        return Onlooker(agent=self.settings.agent_visible, ceiling=self.map_view is None)

    def fingerprint(self) -> tuple[Any, ...] | None:
        """Equal for two events only if both show the same world in the same way. None without a world, and while it moves."""
        world = self._world
        if world is None or not world.at_rest:
            return None
        agent = world.agent
        pose = (*agent.position.tolist(), agent.yaw_deg, agent.horizon_deg, agent.standing, agent.embodiment)
        return (self._worlds, world.version, pose, self.settings, self.width, self.height, self.cameras, self.map_view)
