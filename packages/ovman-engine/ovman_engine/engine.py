"""The engine: answers the actions of one client with metadata and images."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import msgpack

from ovman_engine import MASKS_ONLY
from ovman_engine.client import event
from ovman_engine.client.event import Outcome, thrown
from ovman_engine.client.request import Unintelligible, decoded, sequence_id
from ovman_engine.client.session import Session
from ovman_engine.client.settings import Images
from ovman_engine.client.wire import Field

if TYPE_CHECKING:
    from ovman_engine.picture.camera import Renderer

ACTION_S = 0.1
"""Simulated time that an action takes while physics runs by itself. AI2-THOR's actions take as long as the frames that Unity
draws for them; a tenth of a second lets a dropped object fall and come to rest within the few actions that AI2-THOR needs."""


class Engine:
    """Answers one client, action by action. `session` holds the state that actions read and change."""

    def __init__(self, width: int = 300, height: int = 300, draws: bool = True) -> None:
        """Images are `width` x `height` pixels; with `draws` False no event carries images."""
        self.session = Session(width, height)
        self._draws = draws
        self._renderer: Renderer | None = None
        self._last_state: tuple[Any, ...] | None = None
        self._last_images = Images()
        self._sequence: Any = 0

    def first_message(self) -> list[tuple[Field, bytes | memoryview]]:
        """Frames of the message that the client waits for before it sends anything."""
        return self._message({"action": "", "sequenceId": 0}, Outcome(), Images())

    def answer(self, body: bytes) -> list[tuple[Field, bytes | memoryview]]:
        """Perform the action in `body` (JSON) and returns the frames of the reply.

        Never raises: the client waits without a time limit for a reply. An error is reported in the metadata.
        """
        try:
            request = decoded(body)
        except Unintelligible as error:
            self._sequence = self._sequence + 1 if isinstance(self._sequence, int) else 0
            return self._message({}, Outcome(success=False, message=str(error)), Images())
        self._sequence = sequence_id(request)
        try:
            outcome = self._perform(request)
        except Exception as error:  # a package that the action needs is not installed, or physics diverged
            outcome = thrown(error)
        for images in (self._wanted(request), Images()):
            try:
                return self._message(request, outcome, images)
            except Exception as error:
                self._last_state = None
                outcome = thrown(error)
        metadata = event.agent(self.session, {}, outcome, None, None)
        return [(Field.METADATA, msgpack.packb(event.message(metadata, self._sequence)))]

    def _perform(self, request: Mapping[str, Any]) -> Outcome:
        from ovman_engine.actions import dispatch

        session = self.session
        outcome = dispatch.perform(session, request)
        if not session.loaded:
            return outcome
        session.time_s += ACTION_S
        if session.auto_simulation and not session.world.at_rest:
            session.world.advance(ACTION_S)
        return outcome

    def _wanted(self, request: Mapping[str, Any]) -> Images:
        """Return the images that the reply carries.

        Reset is answered without images: the client sends Initialize before its user sees the event. Class masks always come with
        instance masks, because the client makes its class masks from those.
        """
        if not self._draws or not self.session.loaded or request.get("action") == "Reset" or request.get("renderImage") is False:
            return Images()
        if request.get(MASKS_ONLY) is True:
            return Images(instances=True)
        s = self.session.settings

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
        session = self.session
        if self._renderer is not None and self._renderer.world is not session.world:
            self._renderer = None  # it keeps the former world in memory
        state = session.fingerprint()
        if session.settings.fast_emit and state is not None and state == self._last_state and wanted == self._last_images:
            return [(Field.METADATA_PATCH, msgpack.packb(event.patch(request, outcome, session.time_s)))]
        images: list[tuple[Field, memoryview]] = []
        colours = None
        if wanted.any:
            images, colours = self._draw(wanted)
        agent = event.agent(session, request, outcome, session.scene, colours)
        self._last_state, self._last_images = state, wanted
        return [(Field.METADATA, msgpack.packb(event.message(agent, self._sequence))), *images]

    def _draw(self, wanted: Images) -> tuple[list[tuple[Field, memoryview]], list[dict[str, Any]] | None]:
        """Images of all cameras, and the colour table if masks are among them."""
        from ovman_engine.client.images import AGENT, THIRD_PARTY, colour_table, encoded
        from ovman_engine.picture.camera import Renderer

        session = self.session
        if self._renderer is None:
            self._renderer = Renderer(session.world)
        renderer = self._renderer
        renderer.decor = session.settings.decor
        ids = wanted.instances or wanted.classes
        names = renderer.names
        images = []
        third_party = [
            (camera.view(session.width, session.height, session.onlooker()), THIRD_PARTY) for camera in session.cameras
        ]
        for view, fields in [(session.view(), AGENT), *third_party]:
            frame = renderer.frame(view, rgb=wanted.colour, depth=wanted.depth, ids=ids, normals=wanted.normals)
            images += encoded(frame, names, view, wanted, fields)
        return images, colour_table(names) if ids else None
