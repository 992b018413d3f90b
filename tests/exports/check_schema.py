"""Checks that a file fits a JSON schema, and that files with damage do not.

    check_schema.py SCHEMA.json FILE.json
"""

import json
import sys

import jsonschema


def main():
    with open(sys.argv[1], encoding="utf-8") as file:
        schema = json.load(file)
    with open(sys.argv[2], encoding="utf-8") as file:
        document = json.load(file)
    jsonschema.Draft202012Validator.check_schema(schema)
    validator = jsonschema.Draft202012Validator(schema)
    validator.validate(document)
    for name in schema["required"]:
        damaged = {key: value for key, value in document.items() if key != name}
        assert not validator.is_valid(damaged), f"valid without {name}"
    assert not validator.is_valid(document | {"schema": 1}), "valid with a number as its schema"


main()
