"""The parameters of planning, checking and moving."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

from surefoot import _native
from surefoot.errors import ParameterError

ParameterTables = Mapping[str, Mapping[str, Any]]
"""Tables ``planner``, ``checker`` and ``execution`` with the entries of a scenario file."""


def parameters_of(
    tables: ParameterTables | None, base: _native.Parameters | None = None
) -> _native.Parameters:
    """The parameters ``base``, or the defaults, with the entries of these tables."""
    base = _native.Parameters() if base is None else base
    if not tables:
        return base
    try:
        text = json.dumps({name: dict(table) for name, table in tables.items()})
    except (TypeError, ValueError) as error:
        message = f"parameters must be tables of numbers and names: {error}"
        raise ParameterError(message) from None
    return base.with_json(text)
