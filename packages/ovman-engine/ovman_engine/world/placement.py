"""Which types of objects are placed on which types of receptacles.

The table records facts: what objects lie on in the 120 recorded scenes, and what the pip package ``procthor`` counts on the
furniture of its houses. Closed receptacles, and holders in which an object hangs, are left out: nothing is placed there.
"""

from __future__ import annotations

from collections.abc import Mapping

TOPS = "CoffeeTable Desk DiningTable Dresser Shelf ShelvingUnit SideTable TVStand"
SEATS = "ArmChair Bed Chair Ottoman Sofa"
COUNTERS = "CounterTop DiningTable SideTable"
BASINS = "Sink SinkBasin"

_FOUND = {
    "AlarmClock": f"{TOPS} ArmChair Bed Chair Sofa",
    "AluminumFoil": f"{COUNTERS} Shelf",
    "Apple": f"{TOPS} {BASINS} CounterTop Plate Bowl ArmChair Bed Chair Sofa",
    "BaseballBat": "Floor Bed CoffeeTable Desk DiningTable SideTable Sofa TVStand",
    "BasketBall": "Floor ArmChair Bed Box Chair CoffeeTable DiningTable Dresser ShelvingUnit SideTable Sofa",
    "Book": f"{TOPS} {SEATS} CounterTop",
    "Boots": "Floor",
    "Bottle": f"{TOPS} CounterTop",
    "Bowl": f"{TOPS} CounterTop",
    "Box": f"{TOPS} Floor ArmChair Bed Chair",
    "Bread": "CounterTop DiningTable",
    "ButterKnife": f"{COUNTERS} {BASINS}",
    "CD": f"{TOPS} ArmChair",
    "Candle": f"{TOPS} Bathtub CounterTop Floor Toilet",
    "CellPhone": f"{TOPS} {SEATS} CounterTop Floor",
    "Cloth": f"{COUNTERS} Bathtub BathtubBasin Floor Shelf SinkBasin Toilet",
    "CreditCard": f"{TOPS} Bowl Chair CounterTop Floor",
    "Cup": f"{TOPS} {BASINS} CounterTop",
    "DishSponge": f"{COUNTERS} {BASINS} Bathtub Floor Toilet",
    "Dumbbell": "Floor Desk",
    "Egg": f"{BASINS} CounterTop DiningTable",
    "Footstool": "Floor",
    "Fork": f"{COUNTERS} {BASINS} Desk Plate",
    "HandTowel": "CounterTop",
    "Kettle": "CounterTop DiningTable StoveBurner",
    "KeyChain": f"{TOPS} ArmChair Floor",
    "Knife": f"{COUNTERS} {BASINS}",
    "Ladle": "CounterTop DiningTable",
    "Laptop": "ArmChair Bed Chair CoffeeTable Desk DiningTable Dresser Floor SideTable Sofa TVStand",
    "Lettuce": f"{BASINS} CounterTop DiningTable",
    "Mug": f"{TOPS} {BASINS} CoffeeMachine CounterTop",
    "Newspaper": f"{TOPS} {SEATS} Floor",
    "Pan": "CounterTop DiningTable StoveBurner",
    "PaperTowelRoll": f"{COUNTERS} Toilet",
    "Pen": f"{TOPS} Chair CounterTop Floor",
    "Pencil": f"{TOPS} Box Chair CounterTop Sofa",
    "PepperShaker": f"{COUNTERS} CoffeeTable",
    "Pillow": "ArmChair Bed Chair Floor SideTable Sofa",
    "Plate": f"{TOPS} {BASINS} Chair CounterTop",
    "Plunger": "Floor",
    "Pot": f"{BASINS} CoffeeTable CounterTop Desk DiningTable Dresser ShelvingUnit SideTable StoveBurner TVStand",
    "Potato": f"{COUNTERS} {BASINS}",
    "RemoteControl": f"{TOPS} {SEATS} Floor",
    "SaltShaker": f"{COUNTERS} CoffeeTable",
    "ScrubBrush": "Floor",
    "SoapBar": "Bathtub BathtubBasin CounterTop Dresser Shelf SinkBasin Toilet",
    "SoapBottle": f"{COUNTERS} Bathtub Shelf Sink Toilet",
    "Spatula": f"{COUNTERS} Pot Sink",
    "Spoon": f"{COUNTERS} {BASINS} Plate",
    "SprayBottle": f"{TOPS} CounterTop Floor Toilet",
    "Statue": f"{TOPS} CounterTop Floor",
    "TableTopDecor": TOPS,
    "TeddyBear": f"{SEATS} Desk Floor SideTable",
    "TennisRacket": "Floor Bed CoffeeTable DiningTable SideTable",
    "TissueBox": f"{TOPS} CounterTop Floor Toilet",
    "ToiletPaper": "Bathtub CounterTop Floor GarbageCan Shelf Toilet",
    "Tomato": f"{COUNTERS} {BASINS} Plate",
    "Towel": "Floor",
    "Vase": f"{TOPS} CounterTop Floor",
    "Watch": f"{TOPS} Chair",
    "WateringCan": "Floor Shelf",
    "WineBottle": "CounterTop DiningTable",
}
RECEPTACLES: Mapping[str, frozenset[str]] = {kind: frozenset(found.split()) for kind, found in _FOUND.items()}
"""Type of an object -> types of its receptacles."""
