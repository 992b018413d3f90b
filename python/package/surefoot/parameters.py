"""The parameters of planning, checking and moving."""

from __future__ import annotations

import difflib
import json
from collections.abc import Iterable, Mapping
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
    known = json.loads(base.to_json())
    for table, entries in tables.items():
        _check_name(table, known, f"no table [{table}]")
        for name in entries:
            _check_name(name, known[table], f"[{table}]: no parameter '{name}'")
    return base.with_json(text)


def _check_name(name: str, known: Iterable[str], problem: str) -> None:
    """Raises ParameterError for a name that is not known, with the one that it is nearest to."""
    names = list(known)
    if name in names:
        return
    close = difflib.get_close_matches(name, names, n=1)
    remedy = f"did you mean '{close[0]}'?" if close else f"there are {', '.join(names)}"
    raise ParameterError(f"{problem}; {remedy}", parameter=name)
