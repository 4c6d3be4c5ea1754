"""The JSON schema of config.yaml, made from the models of the settings: python -m ovman.settings.schema.

Editors check and complete config.yaml with it. The Snakefile does not validate with it: the models say in one line what is wrong.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from ovman.atomic import replace_bytes
from ovman.settings import Settings

FILE = Path(__file__).resolve().parents[2] / "workflow" / "schemas" / "config.schema.json"


def schema_text() -> str:
    """Return the schema as text. Sections that begin with "x-" are the user's own; an arm that is null is left out."""
    schema = Settings.model_json_schema(mode="validation")
    schema["$schema"] = "https://json-schema.org/draft/2020-12/schema"
    schema["title"] = "Settings of OVMAN"
    schema["patternProperties"] = {"^x-": {}}
    del schema["required"]  # each file has some of the sections
    split = schema["$defs"]["Split"]
    split["required"] = [name for name in split["required"] if name not in ("scenes", "arms")]
    for section in (schema, *schema["$defs"].values()):
        for of in section.get("properties", {}).values():
            _named_by_their_keys(of, schema["$defs"])
    return json.dumps(_in_words_of_json(schema), indent=2, sort_keys=True) + "\n"


def _named_by_their_keys(of: dict[str, Any], models: dict[str, Any]) -> None:
    """Entries of a mapping take their name from their key; an overlay leaves an entry out with null."""
    entry = of.get("additionalProperties")
    if isinstance(entry, dict) and "$ref" in entry:
        model = models[entry["$ref"].rpartition("/")[2]]
        if model["properties"].pop("name", None) is not None:
            model["required"] = [name for name in model["required"] if name != "name"]
            of["additionalProperties"] = {"anyOf": [entry, {"type": "null"}]}


WORDS = {"ge": "minimum", "gt": "exclusiveMinimum", "le": "maximum", "lt": "exclusiveMaximum", "multiple_of": "multipleOf"}
"""Bounds that pydantic leaves in its own words behind a validator, in JSON Schema's."""


def _in_words_of_json(value: Any) -> Any:
    if isinstance(value, dict):
        return {WORDS.get(key, key): _in_words_of_json(inner) for key, inner in value.items()}
    return [_in_words_of_json(inner) for inner in value] if isinstance(value, list) else value


if __name__ == "__main__":
    FILE.parent.mkdir(parents=True, exist_ok=True)
    replace_bytes(FILE, schema_text().encode())
