"""Substances of objects: for each type the finish of each palette slot.

The type gives the substance, not the colour: a chair is of wood, paint or metal in any of their tones. Only types with a natural
colour (food, foliage) or a customary one (washbasins, toilet paper) have few tones.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from ovman_engine.paint import finishes as f
from ovman_engine.paint.finishes import Finish, either, of, patterned

COMMON: Mapping[str, Finish] = MappingProxyType(
    {
        "main": f.furniture,
        "second": f.furniture,
        "cloth": f.upholstery,
        "cloth_second": f.upholstery,
        "trim": either(f.wood, f.wood, f.black_metal, f.white_paint),
        "accent": f.accent,
        "metal": f.metal,
        "dark": f.dark,
        "pale": f.pale,
        "leaf": f.foliage,
        "leaf_second": f.foliage,
        "soil": f.soil,
        "glow": f.glow,
        "sky": f.outdoors,
        "screen": f.screen,
        "picture": f.picture,
        "pages": f.pages,
        "glass": f.glass,
        "mirror": f.mirror,
        "rubber": f.rubber,
    }
)
"""Every slot, for types that the table does not name and slots that it leaves out."""

_pottery = {"main": f.patterned_glaze, "second": f.glaze, "accent": f.glaze}
_dish = {"main": either(f.ceramic, f.glaze, f.glaze), "second": f.ceramic, "accent": f.glaze, "picture": f.picture}
_cutlery = {"metal": f.steel, "main": either(f.wood, f.steel, f.dark, f.plastic)}
_cookware = {
    "main": either(f.steel, f.steel, f.cast_iron, f.enamel, f.gilt),
    "second": either(f.steel, f.glaze),
    "metal": f.steel,
}
_appliance = {"main": f.enamel, "second": f.enamel, "accent": f.accent, "metal": f.steel, "glow": f.display}
_gadget = {"main": f.casing, "second": f.dark, "accent": f.plastic, "pale": f.pale, "metal": f.steel}
_upholstered = {
    "cloth": f.upholstery,
    "cloth_second": f.upholstery,
    "accent": f.cloth,
    "trim": either(f.wood, f.wood, f.black_metal),
}
_basin = {"main": f.ceramic, "second": f.cabinetry, "metal": f.ceramic, "dark": f.dark}
_fitting = {"metal": either(f.chrome, f.chrome, f.chrome, f.gilt, f.black_metal), "accent": f.chrome, "main": f.chrome}
_shower = {"metal": f.chrome, "pale": f.pale, "cloth": f.drapery}
_paper_roll = {"main": f.paper, "second": of((0.085, 0.3, 0.55), (0.09, 0.2, 0.66), gloss=(0.0, 0.05))}
_towel = {"cloth": f.towelling, "accent": f.towelling}
_bottle = {"picture": f.label, "accent": either(f.plastic, f.gilt, f.dark)}
_lamp = {
    "main": either(f.glaze, f.metal, f.metal, f.wood, f.painted),
    "second": either(f.metal, f.painted),
    "glow": f.shade,
    "trim": either(f.wood, f.metal, f.paint),
}
_framed = {"main": either(f.wood, f.wood, f.white_paint, f.black_metal, f.gilt), "second": f.paper, "picture": f.picture}
_rug = {"cloth": f.cloth, "cloth_second": f.cloth}
_cabinetry = {"main": f.cabinetry, "second": f.cabinetry, "metal": f.metal}

SUBSTANCES: Mapping[str, Mapping[str, Finish]] = MappingProxyType(
    {
        "AlarmClock": _gadget | {"main": either(f.plastic, f.metal, f.wood), "glow": f.display},
        "AluminumFoil": {"main": f.card, "picture": f.label, "metal": f.steel},
        "Apple": {
            "main": of(
                (0.99, 0.62, 0.38), (0.0, 0.6, 0.42), (0.25, 0.5, 0.46), (0.15, 0.55, 0.52), (0.03, 0.55, 0.46), gloss=(0.2, 0.45)
            )
        },
        "ArmChair": _upholstered,
        "BaseballBat": {"main": either(f.wood, f.wood, f.steel, f.dark), "cloth": f.leather},
        "BasketBall": {
            "main": of(
                (0.05, 0.62, 0.42),
                (0.06, 0.6, 0.48),
                (0.04, 0.5, 0.34),
                texture="speckle",
                scale=(0.006, 0.008),
                gloss=(0.0, 0.1),
            )
        },
        "Basin": _basin,
        "Bathtub": {"main": f.ceramic, "second": f.ceramic, "metal": f.chrome},
        "BathtubBasin": _basin,
        "Bed": {
            "main": either(f.wood, f.wood, f.painted),
            "second": f.wood,
            "cloth": f.linen,
            "cloth_second": f.bedding,
            "pale": f.linen,
            "accent": f.bedding,
        },
        "Blinds": {
            "main": either(f.white_paint, f.wood),
            "second": either(f.white_paint, f.white_paint, f.wood, f.grey_paint),
            "trim": f.white_paint,
        },
        "Book": {"main": f.binding, "accent": f.paper, "picture": f.picture},
        "Boots": {"main": either(f.leather, f.leather, f.rubber, f.plastic), "accent": f.leather, "rubber": f.rubber},
        "Bottle": _bottle | {"main": either(f.bottle_glass, f.tinted_glass, f.plastic)},
        "Bowl": _dish,
        "Box": {
            "main": either(f.cardboard, f.cardboard, f.cardboard, f.card),
            "picture": f.label,
            "accent": of((0.09, 0.3, 0.66), (0.1, 0.1, 0.8)),
        },
        "Bread": {
            "main": of(
                (0.085, 0.55, 0.42),
                (0.08, 0.52, 0.36),
                (0.09, 0.55, 0.5),
                texture="speckle",
                scale=(0.02, 0.03),
                gloss=(0.0, 0.15),
            ),
            "second": of((0.1, 0.5, 0.66), (0.1, 0.45, 0.6), gloss=(0.0, 0.05)),
        },
        "ButterKnife": _cutlery,
        "CD": {"metal": of((0.6, 0.05, 0.7), (0.55, 0.1, 0.66), gloss=(0.6, 0.75)), "picture": f.label},
        "Cabinet": _cabinetry,
        "Candle": {"main": f.wax, "accent": either(f.wax, f.gilt), "glow": f.glow},
        "CellPhone": {"main": either(f.casing, f.casing, f.plastic)},
        "Chair": {
            "main": either(f.wood, f.wood, f.wood, f.wood, f.painted, f.metal),
            "second": either(f.wood, f.wood, f.painted),
            "metal": f.metal,
        },
        "Cloth": _towel | {"cloth": patterned(f.towelling, 0.3, (("checker", 0.02, 0.05), ("stripes", 0.02, 0.06)))},
        "CoffeeMachine": _appliance | {"main": either(f.casing, f.casing, f.enamel)},
        "CounterTop": {"main": f.worktop},
        "CreditCard": {"main": f.plastic, "metal": f.gilt},
        "Cup": _dish
        | {
            "main": either(f.ceramic, f.glaze, f.tinted_glass),
            "accent": of((0.06, 0.5, 0.14), (0.08, 0.6, 0.3), (0.1, 0.2, 0.8)),
        },
        "Curtains": {"cloth": f.drapery},
        "DeskLamp": _lamp,
        "Desktop": {"main": f.casing, "second": f.casing},
        "DishSponge": {"main": f.sponge, "second": f.sponge},
        "DogBed": _rug,
        "Drawer": _cabinetry,
        "Dumbbell": {"main": either(f.cast_iron, f.steel, f.plastic), "metal": f.steel, "rubber": either(f.rubber, f.plastic)},
        "Egg": {
            "main": of((0.09, 0.3, 0.86), (0.07, 0.4, 0.7), (0.06, 0.42, 0.6), (0.12, 0.08, 0.9), gloss=(0.05, 0.2), slack=0.03)
        },
        "Faucet": _fitting,
        "FloorLamp": _lamp,
        "Footstool": _upholstered,
        "Fork": _cutlery,
        "Fridge": _appliance | {"screen": f.screen, "picture": f.picture},
        "GarbageBag": {
            "main": of((0.6, 0.04, 0.1), (0.6, 0.05, 0.16), (0.6, 0.06, 0.84), (0.3, 0.2, 0.22), gloss=(0.3, 0.5)),
            "accent": f.plastic,
        },
        "GarbageCan": {
            "main": either(f.steel, f.plastic, f.plastic, f.casing, f.wicker, f.black_metal),
            "second": either(f.steel, f.casing),
            "trim": f.casing,
            "metal": f.steel,
        },
        "HandTowel": _towel,
        "HandTowelHolder": _fitting,
        "HousePlant": {
            "main": either(f.terracotta, f.terracotta, f.ceramic, f.glaze, f.wicker, f.grey_paint),
            "trim": of((0.08, 0.3, 0.28), (0.22, 0.3, 0.3), (0.07, 0.25, 0.4)),
        },
        "Kettle": _cookware | {"main": either(f.steel, f.steel, f.enamel, f.gilt)},
        "KeyChain": {"metal": either(f.steel, f.steel, f.gilt), "cloth": f.leather, "accent": either(f.steel, f.gilt)},
        "Knife": _cutlery | {"main": either(f.dark, f.dark, f.wood)},
        "Ladle": _cutlery,
        "Laptop": _gadget,
        "LaundryHamper": {"main": either(f.wicker, f.wicker, f.plastic), "second": f.wicker, "cloth": f.towelling},
        "Lettuce": {
            "leaf": of((0.26, 0.42, 0.34), (0.25, 0.4, 0.4), (0.29, 0.38, 0.3), texture="leaves", gloss=(0.0, 0.15), slack=0.04),
            "leaf_second": of((0.22, 0.42, 0.52), (0.23, 0.4, 0.46), texture="leaves", gloss=(0.0, 0.15), slack=0.04),
        },
        "LightSwitch": {"main": either(f.white_paint, f.white_paint, f.white_paint, f.metal, f.dark), "second": f.white_paint},
        "Microwave": _appliance,
        "Mirror": {"main": either(f.wood, f.white_paint, f.metal, f.metal)},
        "Mug": _dish | {"main": either(f.ceramic, f.glaze, f.glaze, f.glaze)},
        "Newspaper": {"pages": f.newsprint},
        "Ottoman": _upholstered,
        "Painting": _framed,
        "Pan": _cookware | {"main": either(f.cast_iron, f.cast_iron, f.steel, f.gilt)},
        "PaperTowelRoll": _paper_roll,
        "Pen": {"main": f.plastic, "accent": either(f.plastic, f.gilt), "metal": f.metal},
        "Pencil": {
            "main": of(
                (0.13, 0.66, 0.52), (0.0, 0.6, 0.42), (0.36, 0.4, 0.35), (0.6, 0.5, 0.4), (0.08, 0.5, 0.55), gloss=(0.2, 0.4)
            ),
            "pale": of((0.09, 0.45, 0.7)),
            "accent": of((0.97, 0.45, 0.62), gloss=(0.0, 0.1)),
            "metal": f.gilt,
        },
        "PepperShaker": {"main": either(f.wood, f.steel, f.ceramic, f.dark, f.tinted_glass), "metal": f.steel},
        "Pillow": {"cloth": f.bedding, "accent": f.cloth},
        "Plate": _dish | {"main": either(f.ceramic, f.ceramic, f.glaze)},
        "Plunger": {"rubber": f.rubber, "main": either(f.wood, f.wood, f.plastic)},
        "Poster": {"second": f.paper, "picture": f.picture},
        "Pot": _cookware,
        "Potato": {
            "main": of(
                (0.09, 0.4, 0.5),
                (0.085, 0.45, 0.42),
                (0.02, 0.3, 0.4),
                texture="speckle",
                scale=(0.008, 0.012),
                gloss=(0.0, 0.1),
                slack=0.04,
            ),
            "second": of((0.08, 0.35, 0.26)),
        },
        "RemoteControl": _gadget
        | {
            "main": of((0.6, 0.04, 0.1), (0.6, 0.05, 0.2), (0.6, 0.04, 0.6), (0.1, 0.08, 0.86), gloss=(0.1, 0.4)),
            "pale": of((0.6, 0.04, 0.7), (0.6, 0.03, 0.85), (0.6, 0.05, 0.45)),
            "accent": of((0.0, 0.7, 0.45)),
        },
        "RoomDecor": _pottery
        | {"trim": of((0.08, 0.3, 0.28), (0.09, 0.3, 0.5)), "leaf": of((0.1, 0.3, 0.6), (0.95, 0.3, 0.6), (0.28, 0.3, 0.36))},
        "Safe": {"main": either(f.grey_paint, f.dark, f.steel), "second": f.grey_paint, "metal": f.steel},
        "SaltShaker": {"main": either(f.ceramic, f.tinted_glass, f.steel, f.wood), "metal": f.steel},
        "ScrubBrush": {"main": either(f.ceramic, f.plastic, f.steel), "second": f.plastic, "metal": f.chrome},
        "Shelf": _cabinetry,
        "ShowerCurtain": _shower,
        "ShowerDoor": _shower,
        "ShowerGlass": _shower,
        "ShowerHead": _fitting | {"dark": f.grey_paint},
        "Sink": {"main": either(f.steel, f.steel, f.ceramic), "second": f.cabinetry, "metal": f.chrome},
        "SinkBasin": {"metal": either(f.steel, f.steel, f.ceramic)},
        "SoapBar": {"main": f.soap, "second": f.soap},
        "SoapBottle": _bottle
        | {"main": either(f.plastic, f.tinted_glass, f.ceramic), "accent": either(f.chrome, f.plastic, f.dark)},
        "Sofa": _upholstered,
        "Spatula": _cutlery,
        "Spoon": _cutlery | {"dark": f.steel},
        "SprayBottle": _bottle | {"main": either(f.plastic, f.plastic, f.tinted_glass), "accent": f.plastic},
        "Statue": {"main": f.sculpture, "second": either(f.sculpture, f.stone, f.wood), "accent": f.sculpture},
        "Stool": {"main": either(f.wood, f.wood, f.painted, f.metal), "second": either(f.wood, f.wood, f.painted)},
        "Stove": _appliance | {"second": either(f.cast_iron, f.steel), "metal": f.steel, "main": f.enamel},
        "StoveBurner": {"main": f.cast_iron, "second": either(f.steel, f.dark, f.cast_iron)},
        "StoveKnob": {"main": either(f.dark, f.dark, f.steel, f.white_paint), "metal": f.steel, "accent": f.pale},
        "TableTopDecor": _pottery | {"main": either(f.wood, f.metal, f.glaze)},
        "TeddyBear": {"cloth": f.fur, "cloth_second": f.fur},
        "Television": {
            "main": of((0.6, 0.04, 0.08), (0.6, 0.04, 0.14), (0.6, 0.04, 0.45), gloss=(0.2, 0.5), slack=0.03),
            "metal": f.metal,
        },
        "TennisRacket": {"main": either(f.plastic, f.dark, f.wood), "cloth": f.leather},
        "TissueBox": {"main": f.card, "picture": f.label, "pale": f.paper},
        "Toaster": _appliance | {"accent": of((0.09, 0.5, 0.5))},
        "Toilet": {"main": f.ceramic, "second": either(f.ceramic, f.ceramic, f.ceramic, f.wood), "metal": f.chrome},
        "ToiletPaper": _paper_roll,
        "ToiletPaperHanger": _fitting,
        "Tomato": {"main": of((0.0, 0.72, 0.42), (0.015, 0.72, 0.46), (0.99, 0.66, 0.36), gloss=(0.25, 0.45), slack=0.04)},
        "Towel": _towel,
        "TowelHolder": _fitting,
        "VacuumCleaner": {"main": f.plastic, "second": either(f.plastic, f.casing), "metal": f.steel},
        "Vase": _pottery
        | {"main": either(f.patterned_glaze, f.patterned_glaze, f.patterned_glaze, f.terracotta, f.tinted_glass, f.metal)},
        "Watch": {"cloth": f.leather, "metal": f.metal},
        "WateringCan": {"main": either(f.steel, f.plastic, f.paint, f.gilt), "metal": f.metal},
        "Window": {"trim": either(f.white_paint, f.white_paint, f.white_paint, f.wood, f.grey_paint)},
        "WineBottle": _bottle | {"main": f.bottle_glass},
    }
)
"""Type (or "Stove", "Basin": the bathroom's sinks) -> slot -> finish, where it differs from `COMMON`."""


IN_HOUSES: Mapping[str, Mapping[str, Finish]] = {
    "Box": {"main": either(f.cardboard, f.card, f.card, f.plastic, f.wicker), "accent": f.cloth},
    "Laptop": {"main": either(f.casing, f.plastic, f.paint, f.gilt), "second": either(f.dark, f.pale)},
    "LaundryHamper": {"main": either(f.wicker, f.plastic, f.towelling, f.paint), "cloth": f.bedding},
}
"""As `SUBSTANCES`, for objects of houses: several assets of these types are in one house and have to be told apart."""


def finish(kind: str, slot: str, in_house: bool = False) -> Finish:
    """Return the finish of a palette slot of a type. Raises KeyError for an unknown slot."""
    own = IN_HOUSES.get(kind, {}).get(slot) if in_house else None
    return own or SUBSTANCES.get(kind, {}).get(slot) or COMMON[slot]
