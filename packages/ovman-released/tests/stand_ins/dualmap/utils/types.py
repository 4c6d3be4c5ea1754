"""What a frame is handed over as, and what is seen of an object in one."""

from dataclasses import dataclass
from typing import Any


@dataclass
class DataInput:
    idx: int
    time_stamp: float
    color: Any
    depth: Any
    color_name: str
    intrinsics: Any
    pose: Any


@dataclass
class LocalObservation:
    idx: int
    class_id: int
