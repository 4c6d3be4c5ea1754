"""Stage `readmitted_maps`: maps of the tours of every trial that some setting of the thresholds admits.

One job makes them all: most tours are those of released episodes and were looked at before. The networks are loaded once for the
others.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

from ovman.perception.detections import looked_at, networks_of
from ovman.perception.maps import mapped
from ovman.perception.records import write_maps
from ovman.settings import Settings


def run(visits: Sequence[Mapping[str, Path]], constants: Settings, code: Sequence[str], kept: Path, maps: Sequence[Path]) -> None:
    """Writes the maps of the visits of each scene (name -> directory of its recording), one file for each scene in their order.

    code, kept: as for ``looked_at``, which says what is raised.
    """
    loaded = networks_of(constants)
    for of_scene, output in zip(visits, maps, strict=True):
        seen = looked_at(of_scene, constants, code, kept, loaded)
        write_maps(output, {name: mapped((one,), constants.maps.cluster_radius_m) for name, one in seen.items()})
