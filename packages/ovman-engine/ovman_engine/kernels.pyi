"""The compiled kernels (kernels/*.cpp). Arrays are float32 or int32 and C-contiguous, or are converted."""

from collections.abc import Sequence

import numpy as np

class Solid:
    """The triangles of a mesh, ready to be drawn and met by rays; fields as in triangle_mesh.TriangleMesh."""

    def __init__(
        self,
        vertices: np.ndarray,
        triangles: np.ndarray,
        normals: np.ndarray,
        instance: np.ndarray,
        material: np.ndarray,
        part: np.ndarray,
        axis: np.ndarray,
        frames: np.ndarray,
        extents: np.ndarray,
    ) -> None: ...
    def __len__(self) -> int: ...

class Rig:
    """The lights of a scene; fields as in lights.Rig. `sun` (2, 3): way and colour, or (0, 3)."""

    def __init__(
        self,
        lamps: np.ndarray,
        shadowed: int,
        samples: np.ndarray,
        ambient: np.ndarray,
        exposure: float,
        sun: np.ndarray,
        panes: np.ndarray,
    ) -> None: ...

class Field:
    """Light on a fixed solid without its `hidden` triangles (T,), and on a moved one.

    `before` is the light of the whole fixed solid, of which all is kept that no ball of `changes` (N, 4), centre and radius in
    metres, can alter.
    """

    def __init__(
        self, fixed: Solid, hidden: np.ndarray, moved: Solid, rig: Rig, before: Field | None, changes: np.ndarray
    ) -> None: ...

class Materials:
    """Materials by number; fields as in painter.Appearance."""

    def __init__(
        self,
        colours: np.ndarray,
        kinds: np.ndarray,
        scales: np.ndarray,
        seeds: np.ndarray,
        glosses: np.ndarray,
        emissions: np.ndarray,
        clear: np.ndarray,
    ) -> None: ...

class Camera:
    """A camera.View; `axes` (3, 3): right, up and forward in rows; `flat`: orthographic."""

    def __init__(
        self,
        eye: np.ndarray,
        axes: np.ndarray,
        tan_x: float,
        tan_y: float,
        near: float,
        far: float,
        width: int,
        height: int,
        flat: bool,
    ) -> None: ...

def draw(
    field: Field,
    hidden: np.ndarray,
    extra: Solid,
    materials: Materials,
    noise: np.ndarray,
    curve: np.ndarray,
    camera: Camera,
    sky: Sequence[int] | None,
    rgb: bool,
    normals: bool,
) -> dict[str, np.ndarray]: ...
def closest(
    solids: Sequence[Solid], origins: np.ndarray, ways: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]: ...
def corner_normals(
    vertices: np.ndarray, triangles: np.ndarray, part: np.ndarray, turns: np.ndarray, cosine: float
) -> tuple[np.ndarray, np.ndarray]: ...
