"""OVMAN: open-vocabulary motion-aware navigation, a task and benchmark."""

__version__ = "0.17.0"
