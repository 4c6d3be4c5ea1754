"""The benchmark as a Gymnasium environment. Importing this package registers "OVMAN-v1" (`ovman.gym.environment.Environment`).

Gymnasium has no entry points that register by themselves since its version 1.0: `import ovman.gym`, or make
"ovman.gym:OVMAN-v1". ModuleNotFoundError in one line where Gymnasium is not installed.
"""

from __future__ import annotations

try:
    from gymnasium.envs.registration import register, registry
except ModuleNotFoundError as missing:
    absent = str(missing.name).partition(".")[0]
    raise ModuleNotFoundError(f"{absent} is not installed; in a checkout of OVMAN: pip install '.[gym]'", name=absent) from None

ID = "OVMAN-v1"
"""What `gymnasium.make` calls the environment."""

if ID not in registry:
    register(id=ID, entry_point="ovman.gym.environment:Environment")
