"""Kinds of episodes; imports what present setuptools no longer has."""

from enum import Enum
from importlib import import_module

version = import_module("pkg_resources").packaging.version
import_module("matplotlib")


class EnvTypes(Enum):
    NORMAL = 0
    ROBOTHOR = 1


class ClassTypes(Enum):
    REGULAR = 0
    LONGTAIL = 1
