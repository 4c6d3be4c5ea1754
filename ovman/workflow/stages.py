"""Which stage owns which constant of config.yaml."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from ovman.settings.settings import matching

# "a.b" is one constant, "a.*" is all of a section. A change reruns the stages that own the constant and all that follow them.
# evaluation.seeds decides which files exist; no stage owns it.
# evaluation.scenes_per_job decides which job makes a file; no stage owns it.
_SIMULATOR = ("benchmark.backend", "camera.*", "primitives.step_m", "primitives.turn_deg")
_RUNNING = ("benchmark.seed", "benchmark.backend", "camera.*", "primitives.*", "success.sweep_deg") + (
    _GAIT := ("mover.pause_probability", "mover.turn_probability")
)
_DETECTING = tuple(f"perception.detector.{name}" for name in ("architecture", "side_px", "confidence", "min_mask_px"))
_METRICS = (
    "arms",
    "comparisons.agent",
    "comparisons.rungs",
    "comparisons.pairs",
    "comparisons.pairings",
    "comparisons.readings",
    "benchmark.seed",
    "success.radius_m",
    "single_visit.samples",
    "evaluation.confidence",
    "evaluation.near_miss_m",
    "candidates.delta_min_m",
)
_JUDGING = (
    "candidates.delta_min_m",
    "candidates.spawn_clearance_m",
    "candidates.spawn_beyond_m",
    "candidates.crowding_m",
    "candidates.apart_m",
    "admissibility.tau_m",
    "admissibility.min_mask_px",
    "admissibility.validity_radius_m",
    "admissibility.drift_tolerance_m",
    "admissibility.motion_m",
    "admissibility.mover_spread_m",
    "admissibility.above_chance",
    "success.visible_px",
)
STAGES: Mapping[str, tuple[str, ...]] = {
    "simulator": ("benchmark.backend",),
    "scenes": (*_SIMULATOR, "tour.waypoints", "mover.step_m"),
    "candidates": (
        "benchmark.seed",
        "candidates.*",
        "splits.*",
        "sensors.*",
        "tour.headings",
        "mover.*",
        "primitives.step_m",
    ),
    "trials": (*_SIMULATOR, *_GAIT, "benchmark.seed", "measurement.*", "success.sweep_deg"),
    "admissible": _JUDGING,
    "certified": (*_RUNNING, "admissibility.runs"),
    "episodes": (
        "benchmark.seed",
        "benchmark.backend",
        "splits.*",
        "camera.*",
        "primitives.*",
        "mover.*",
        "benchmark.allow_short_split",
        "success.*",
    ),
    "pictures": (
        "benchmark.backend",
        "camera.*",
        "primitives.step_m",
        "primitives.turn_deg",
        "training.seed",
        "training.views",
        "training.held_out_views",
        "splits.*",
    ),
    "crops": ("perception.encoder.crop_padding", "training.encoder.crop_px"),
    "detector": (
        "training.seed",
        "training.detector.*",
        *_DETECTING,
    ),
    "detected": (
        *_DETECTING,
        "perception.encoder.crop_padding",
        "training.encoder.crop_px",
        "training.encoder.detected_one_in",
    ),
    "encoder": ("training.seed", "training.encoder.*"),
    "models": ("training.*", "splits.*"),
    "detections": ("camera.field_of_view_deg", "perception.*"),
    "cues": (
        "camera.field_of_view_deg",
        "appearance.hue_bins",
        "appearance.saturation_bins",
        "appearance.extent_share",
    ),
    "labels": (),
    "maps": ("maps.*",),
    "maintained": ("maps.*",),
    "segments": ("joint.every_px", "joint.tolerance_m", "joint.tolerance_per_m", "joint.part_cells", "joint.doubt"),
    "nouns": ("perception.device", "perception.trust_pickles", "perception.encoder.*"),
    # The seed, the camera, the primitives, the mover and the success test of what follows are those of each episode.
    "walks": ("perception.*", "dualmap.runs", "dualmap.walk.*", "dualmap.observation.*"),
    "dualmap": ("dualmap.runs", "dualmap.local_map.*"),
    "dualmap_objects": (),
    # And of each arm the constants that its entry in section `arms` names.
    "predictions": ("admissibility.min_mask_px",),
    "rollouts": ("admissibility.min_mask_px",),
    "scores": (),
    "metrics": _METRICS,
    "split_tables": ("arms", "splits.*", "success.radius_m", "evaluation.confidence"),
    "controls": ("arms", "comparisons.controls", "comparisons.overview", "comparisons.pairs", "evaluation.confidence"),
    "static_tables": (*_METRICS, "comparisons.difficulty", "comparisons.shortcuts"),
    "language": (
        "comparisons.agent",
        "grounding.*",
        "association.*",
        "admissibility.tau_m",
        "success.radius_m",
        "evaluation.confidence",
    ),
    "perception": ("perception.detector.min_mask_px",),
    # The episodes of these are made as those of the stage episodes are.
    "readmitted": (
        *_JUDGING,
        "sensitivity.*",
        "benchmark.seed",
        "benchmark.backend",
        "camera.*",
        "primitives.*",
        "mover.*",
        "success.*",
    ),
    "readmitted_maps": ("camera.field_of_view_deg", "perception.*", "maps.*"),
    # And of each arm the constants that its entry in section `arms` names.
    "readmitted_predictions": ("admissibility.min_mask_px",),
    "sensitivity": (
        *_JUDGING,
        "sensitivity.*",
        "comparisons.memory.*",
        "benchmark.seed",
        "success.radius_m",
        "single_visit.samples",
    ),
    # Everything else of the ablation is each episode's own.
    "ablation_episodes": (),
    "ablated_tours": ("benchmark.backend", "measurement.min_mask_px"),
    "ablated_maps": ("camera.field_of_view_deg", "perception.*", "maps.*"),
    # And of each arm the constants that its entry in section `arms` names.
    "ablated_predictions": ("admissibility.min_mask_px",),
    "ablation": (
        "arms",
        "comparisons.ablation",
        "benchmark.seed",
        "success.radius_m",
        "single_visit.samples",
        "evaluation.confidence",
    ),
    # And the constants that the entry of comparisons.memory.arm names.
    "probes": (
        "comparisons.memory.arm",
        "gate_sweep.*",
        "association.gate_m",
        "candidates.delta_min_m",
        "admissibility.min_mask_px",
        "success.radius_m",
        "evaluation.confidence",
    ),
    "fragments": ("comparisons.memory.arm", "success.radius_m", "perception.detector.min_mask_px"),
    "backprojection": ("camera.field_of_view_deg", "perception.detector.min_mask_px"),
    "appearance": (
        "appearance.agent",
        "appearance.least_extent_m",
        "appearance.weight_step",
        "appearance.equal_scales",
        "appearance.least_pairs",
        "association.*",
        "admissibility.tau_m",
        "success.radius_m",
        "evaluation.confidence",
    ),
    "figures": ("camera.*", "admissibility.min_mask_px"),
    "charts": (
        "arms",
        "comparisons.agent",
        "comparisons.difficulty",
        "comparisons.controls",
        "paper.*",
    ),
    "paper_comparison": (
        "arms",
        "comparisons.agent",
        "comparisons.controls",
        "paper.*",
        "benchmark.backend",
        "perception.detector.architecture",
        "perception.detector.weights",
        "perception.encoder.model",
        "perception.encoder.weights",
        "evaluation.confidence",
    ),
    "tables": (
        "arms",
        "splits.*",
        "comparisons.agent",
        "comparisons.memory.*",
        "comparisons.rungs",
        "comparisons.difficulty",
        "comparisons.shortcuts",
        "comparisons.controls",
        "tour.*",
        "success.*",
        "candidates.delta_min_m",
        "candidates.spawn_clearance_m",
        "candidates.spawn_beyond_m",
        "candidates.crowding_m",
        "candidates.apart_m",
        "association.*",
        "grounding.*",
        "maps.*",
        "admissibility.*",
        "primitives.*",
        "mover.*",
        "single_visit.samples",
        "evaluation.confidence",
        "evaluation.near_miss_m",
        "perception.detector.confidence",
        "perception.detector.min_mask_px",
    ),
}


def owned(stage: str, names: Iterable[str]) -> tuple[str, ...]:
    """Those of `names` (dotted) that a stage owns, sorted. Raises KeyError for a stage that is not in STAGES."""
    return matching(STAGES[stage], names)


_DRAWN = ("name", "in_main_job", "scenes", "changes", "others", "second_tour", "light", "sensors", "draws", "tries")
ENTRIES: Mapping[str, Mapping[str, tuple[str, ...]]] = {
    "candidates": {"splits": _DRAWN},
    "pictures": {"splits": ("name", "scenes")},
    "models": {"splits": ("name", "scenes")},
    "episodes": {"splits": (*_DRAWN, "episodes", "instances_in_turn", "sizes_in_turn")},
}
"""Of the entries of these sections a stage owns these fields only: who answers a split changes no episode of it."""
