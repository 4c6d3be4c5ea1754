"""The JSON schema of config.yaml, made from the models of the settings: python -m ovman.workflow.schema.

Editors check and complete config.yaml with it. The Snakefile does not validate with it: the models say in one line what is wrong.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ovman.atomic import replace_bytes
from ovman.models.settings import Settings

FILE = Path(__file__).resolve().parents[2] / "workflow" / "schemas" / "config.schema.json"


def schema_text() -> str:
    """The schema as text. Sections that begin with "x-" are the user's own; an arm that is null is left out."""
    schema = Settings.model_json_schema(mode="validation")
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Settings of OVMAN"
    schema["patternProperties"] = {"^x-": {}}
    # The key of its entry names an arm, and an overlay leaves an arm out with null.
    arm = schema["$defs"]["Arm"]
    arm["required"] = [name for name in arm["required"] if name != "name"]
    arm["properties"].pop("name")
    arms = schema["properties"]["arms"]
    arms["additionalProperties"] = {"anyOf": [arms["additionalProperties"], {"type": "null"}]}
    return json.dumps(_in_words_of_json(schema), indent=2, sort_keys=True) + "\n"


WORDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum", "multiple_of": "multipleOf"}
"""Bounds that pydantic leaves in its own words behind a validator, in JSON Schema's."""


def _in_words_of_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {WORDS.get(key, key): _in_words_of_json(inner) for key, inner in value.items()}
    return [_in_words_of_json(inner) for inner in value] if isinstance(value, list) else value


if __name__ == "__main__":
    FILE.parent.mkdir(parents=True, exist_ok=True)
    replace_bytes(FILE, schema_text().encode())
