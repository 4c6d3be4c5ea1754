"""Is there all that DualMap's released code needs: clone, environment, weights, GPU?"""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from pathlib import Path

from ovman_released import interpreter
from ovman_released.clone import Clone
from ovman_released.plugin import DUALMAP, ReleasedDualmap

SYSTEM = "DualMap (released)"
REPOSITORY = "https://github.com/Eku127/DualMap"
OLDEST = (3, 10)
"""DualMap's own Python; its process imports nothing of this package."""
WEIGHTS = ("model/yolov8l-world.pt", "model/mobile_sam.pt", "model/FastSAM-s.pt")
"""Of the detector and the two segmenters, in the clone."""
TOWERS = "apple/MobileCLIP-S2-OpenCLIP"
_FETCH = (
    "import open_clip; from ultralytics import YOLO, SAM, FastSAM; "
    "YOLO('model/yolov8l-world.pt').set_classes(['chair']); SAM('model/mobile_sam.pt'); FastSAM('model/FastSAM-s.pt'); "
    "open_clip.create_model_and_transforms('MobileCLIP-S2', pretrained='datacompdr')"
)
"""Downloads all weights; the detector fetches the text tower that names its classes when it is given the first."""
NEEDS = interpreter.Needs(
    modules={
        "torch": "torch",
        "hydra": "hydra-core",
        "open3d": "open3d",
        "open_clip": "open_clip_torch",
        "ultralytics": "ultralytics==8.3.103",
        "clip": "git+https://github.com/ultralytics/CLIP.git",
        "supervision": "supervision==0.25.1",
        "faiss": "faiss-cpu==1.9.0",
        "rerun": "rerun-sdk==0.22.1",
        "kornia": "kornia",
        "natsort": "natsort",
        "imageio": "imageio",
        "dill": "dill",
        "sklearn": "scikit-learn",
        "pympler": "pympler",
        "tabulate": "tabulate",
    },
    versions={},
    cached={
        TOWERS: (
            (("open_clip_model.safetensors", "open_clip_pytorch_model.bin"),),
            f"-c {shlex.quote(_FETCH)}",
        )
    },
    oldest=OLDEST,
    imported={
        "open3d": "it needs the system libraries libusb-1.0, libGL, libgomp and libX11",
        "rerun": "it needs a pyarrow that takes this NumPy: pyarrow<26",
    },
)


@dataclass(frozen=True, slots=True)
class Installation:
    """root: of the clone; python: the interpreter of its environment; before: a Python file whose function `before` a run calls
    before DualMap is built, for networks that stand in for DualMap's, or None.
    """

    root: Path
    python: Path
    before: Path | None = None


def lacks(dualmap: ReleasedDualmap) -> str | None:
    """What is missing and how to get it, in one line, given section `released_dualmap`; None where everything is there."""
    if not dualmap.root:
        return f"{DUALMAP}.root names no clone; packages/ovman-released/README.md says how to make one"
    root = Path(dualmap.root).absolute()
    return (
        Clone(REPOSITORY, root, dualmap.commit).lacks()
        or interpreter.lacks(DUALMAP, dualmap.python, dualmap.device, NEEDS, environment())
        or interpreter.lacks(DUALMAP, dualmap.python, "cpu", submodule(root), environment())
        or missing_weights(root, dualmap.python)
    )


def submodule(root: Path) -> interpreter.Needs:
    """MobileCLIP's code, from the clone's submodule: without what it depends on, which would replace the environment's torch."""
    place = shlex.quote(str(root / "3rdparty" / "mobileclip"))
    return interpreter.Needs({"mobileclip": f"--no-deps --editable {place}"}, {}, {}, OLDEST)


def environment() -> dict[str, str]:
    """Environment variables for a process of DualMap: as for every released system, and nothing is installed."""
    return interpreter.environment() | {"YOLO_OFFLINE": "true", "YOLO_AUTOINSTALL": "false"}


def missing_weights(root: Path, python: str) -> str | None:
    """The first file of weights that is not in the clone at `root` and how to get it; None where all are there."""
    for name in WEIGHTS:
        if not (root / name).is_file():
            return f"there is no {name} in {root}; in that folder run {shlex.quote(python)} -c {shlex.quote(_FETCH)}"
    return None
