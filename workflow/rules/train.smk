# The networks of the default configuration, trained again in some hours: snakemake --cores 2 results/models. Needs `make setup-networks`.

from training.floorplans import floor_plans, home_names

PLANS = floor_plans(SPLITS["main"].scenes)
PICTURED = (*PLANS.taught, *PLANS.held_out)
HOMES = home_names("train", CONSTANTS["training.homes"])
HELD_OUT = {"floor_plans": PLANS.held_out, "homes": home_names("val", CONSTANTS["training.held_out_homes"])}
DETECTING = [f"perception.detector.{name}" for name in ("architecture", "side_px", "confidence", "min_mask_px")]


rule pictures:
    output:
        pictures=directory("results/training/pictures/{scene}"),
    log:
        "logs/pictures/{scene}.log",
    resources:
        gpu=GPU,
    params:
        constants=pick(
            *("benchmark.backend", "camera", "primitives.step_m", "primitives.turn_deg"),
            *("training.seed", "training.views", "training.held_out_views", "training.home_views", "training.left_out"),
        ),
        held_out=lambda wildcards: wildcards.scene in (*PLANS.held_out, *HELD_OUT["homes"]),
        code=digest_code("training.pictures"),
    script:
        "../scripts/train.py"


rule detector_first:
    input:
        taught=expand("results/training/pictures/{scene}", scene=PLANS.taught),
        held_out=expand("results/training/pictures/{scene}", scene=PLANS.held_out),
    output:
        weights="results/training/detector_first.safetensors",
        curve="results/training/detector_first.jsonl",
    log:
        "logs/detector_first.log",
    params:
        constants=pick("training.seed", "training.detector", *DETECTING),
        code=digest_code("training.detector"),
    script:
        "../scripts/train.py"


# Further, without mosaics, on homes as well.
rule detector:
    input:
        taught=expand("results/training/pictures/{scene}", scene=(*PLANS.taught, *HOMES)),
        held_out=expand("results/training/pictures/{scene}", scene=(*PLANS.held_out, *HELD_OUT["homes"])),
        start="results/training/detector_first.safetensors",
    output:
        weights="results/training/detector.safetensors",
        curve="results/training/detector.jsonl",
    log:
        "logs/detector.log",
    params:
        constants=pick("training.seed", "training.detector", *DETECTING),
        code=digest_code("training.detector"),
    script:
        "../scripts/train.py"


rule crops:
    input:
        pictures="results/training/pictures/{scene}",
    output:
        crops="results/training/crops/true/{scene}.npz",
    log:
        "logs/crops/{scene}.log",
    params:
        constants=pick("training.seed", "perception.encoder.crop_padding", "training.encoder.crop_px", "training.encoder.views"),
        code=digest_code("training.crops"),
    script:
        "../scripts/train.py"


# Around the masks of the detector that the settings name.
rule detected:
    input:
        pictures=expand("results/training/pictures/{scene}", scene=(*PICTURED, *HOMES, *HELD_OUT["homes"])),
        weights=weights("detector.weights"),
    output:
        crops=expand("results/training/crops/detected/{scene}.npz", scene=(*PICTURED, *HOMES, *HELD_OUT["homes"])),
    log:
        "logs/detected.log",
    params:
        constants=pick(
            *("perception.encoder.crop_padding", "training.encoder.crop_px", "training.encoder.views"),
            *("perception.device", "perception.trust_pickles", "perception.detector"),
        ),
        code=digest_code("training.crops"),
    script:
        "../scripts/train.py"


# Of published weights alone.
rule texts:
    output:
        texts="results/training/encoder.text.onnx",
    log:
        "logs/texts.log",
    params:
        code=digest_code("training.export"),
    script:
        "../scripts/train.py"


rule encoder:
    input:
        taught=expand("results/training/crops/{masks}/{scene}.npz", masks=("true", "detected"), scene=(*PLANS.taught, *HOMES)),
        floor_plans=expand("results/training/crops/detected/{scene}.npz", scene=HELD_OUT["floor_plans"]),
        homes=expand("results/training/crops/detected/{scene}.npz", scene=HELD_OUT["homes"]),
        texts="results/training/encoder.text.onnx",
    output:
        weights="results/training/encoder.safetensors",
        graph="results/training/encoder.onnx",
        curve="results/training/encoder.jsonl",
    log:
        "logs/encoder.log",
    params:
        constants=pick("training.seed", "training.encoder", "training.left_out"),
        code=digest_code("training.encoder"),
    script:
        "../scripts/train.py"


# The files of models/ but for the cards.
rule models:
    input:
        pictures=expand("results/training/pictures/{scene}", scene=PICTURED),
        crops=expand("results/training/crops/{masks}/{scene}.npz", masks=("true", "detected"), scene=(*PLANS.taught, *HOMES)),
        detector="results/training/detector.safetensors",
        detector_first_curve="results/training/detector_first.jsonl",
        detector_curve="results/training/detector.jsonl",
        encoder="results/training/encoder.safetensors",
        graph="results/training/encoder.onnx",
        texts="results/training/encoder.text.onnx",
        encoder_curve="results/training/encoder.jsonl",
    output:
        models=directory("results/models"),
    log:
        "logs/models.log",
    params:
        constants=pick("training", "perception.detector.architecture"),
        scenes=list(SPLITS["main"].scenes),
        code=digest_code("training.models"),
    script:
        "../scripts/train.py"
