"""Which stage owns which constant of config.yaml."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

# "a.b" is one constant, "a.*" is all of a section. A change reruns the stages that own the constant and all that follow them.
# benchmark.scenes and evaluation.seeds decide which files exist; stages own them only if they write them into records.
_SIMULATOR = ("benchmark.backend", "camera.*", "primitives.step_m", "primitives.turn_deg")
_RUNNING = ("benchmark.seed", "benchmark.backend", "camera.*", "primitives.*", "success.sweep_deg") + (
    _GAIT := ("mover.step_m", "mover.pause_probability", "mover.turn_probability")
)
_DETECTING = tuple(f"perception.detector.{name}" for name in ("architecture", "side_px", "confidence", "min_mask_px"))
_METRICS = (
    "arms",
    "comparisons.agent",
    "comparisons.rungs",
    "comparisons.pairs",
    "comparisons.pairings",
    "benchmark.seed",
    "success.radius_m",
    "single_visit.samples",
    "evaluation.confidence",
    "evaluation.near_miss_m",
)
STAGES: Mapping[str, tuple[str, ...]] = {
    "simulator": ("benchmark.backend",),
    "scenes": (*_SIMULATOR, "tour.waypoints"),
    "candidates": (
        "benchmark.seed",
        "candidates.*",
        "tour.headings",
        "mover.lane_min_m",
        "primitives.step_m",
    ),
    "trials": (*_SIMULATOR, *_GAIT, "benchmark.seed", "tour.headings", "measurement.*", "success.sweep_deg"),
    "admissible": (
        "candidates.delta_min_m",
        "candidates.spawn_clearance_m",
        "admissibility.tau_m",
        "admissibility.min_mask_px",
        "admissibility.validity_radius_m",
        "admissibility.drift_tolerance_m",
        "admissibility.motion_m",
        "success.visible_px",
    ),
    "certified": (*_RUNNING, "admissibility.runs"),
    "episodes": (
        "benchmark.seed",
        "benchmark.backend",
        "benchmark.scenes",
        "benchmark.split.*",
        "tour.headings",
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
        "benchmark.scenes",
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
    "models": ("training.*", "benchmark.scenes"),
    "detections": ("camera.field_of_view_deg", "perception.*"),
    "maps": ("maps.*",),
    "nouns": ("perception.device", "perception.trust_pickles", "perception.encoder.*"),
    # The seed, the camera, the primitives, the mover and the success test of what follows are those of each episode.
    "walks": ("perception.*", "dualmap.runs", "dualmap.walk.*", "dualmap.observation.*"),
    "dualmap": ("dualmap.runs", "dualmap.maintained", "dualmap.local_map.*", "dualmap.global_map.*"),
    "dualmap_objects": (),
    # And of each arm the constants that its entry in section `arms` names.
    "predictions": ("admissibility.min_mask_px",),
    "rollouts": ("admissibility.min_mask_px",),
    "scores": (),
    "metrics": _METRICS,
    "static_tables": (*_METRICS, "comparisons.difficulty"),
    "language": (
        "comparisons.agent",
        "grounding.*",
        "association.*",
        "admissibility.tau_m",
        "success.radius_m",
        "evaluation.confidence",
    ),
    "perception": ("perception.detector.min_mask_px",),
    "backprojection": ("camera.field_of_view_deg", "perception.detector.min_mask_px"),
    "figures": ("camera.*", "admissibility.min_mask_px"),
    "paper_comparison": (
        "arms",
        "comparisons.agent",
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
        "comparisons.agent",
        "comparisons.difficulty",
        "tour.*",
        "success.*",
        "candidates.delta_min_m",
        "candidates.spawn_clearance_m",
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


def matching(patterns: Iterable[str], names: Iterable[str]) -> tuple[str, ...]:
    """Those of `names` (dotted) that are among the patterns, "a.b" or "a.*"; sorted."""
    patterns = tuple(patterns)
    beginnings = tuple(pattern.removesuffix("*") for pattern in patterns if pattern.endswith(".*"))
    return tuple(sorted(name for name in names if name in patterns or name.startswith(beginnings)))
