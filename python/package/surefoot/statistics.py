"""The statistics of a batch as one page: ``python -m surefoot.statistics DIR``."""

from __future__ import annotations

import html
import os
import sys
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from surefoot.errors import InputError, missing
from surefoot.walks import MARGINS

BINS = 24
"""Bars of a histogram."""
WIDTH, HEIGHT = 480, 120
STYLE = (
    "body{font:15px sans-serif;margin:2em auto;max-width:72em;padding:0 1em}"
    "table{border-collapse:collapse;margin:1em 0}td,th{padding:.2em .8em;text-align:right}"
    "th{border-bottom:1px solid #888}td:first-child,th:first-child{text-align:left}"
    "figure{display:inline-block;margin:0 1em 1em 0}rect{fill:#4285f4}"
)


def write_page(out: str | os.PathLike[str]) -> Path:
    """Writes ``statistics.html`` into the folder of a batch, from its two tables."""
    try:
        import pyarrow.parquet as parquet
    except ImportError:
        raise missing("pyarrow", "batch") from None
    folder = Path(out)
    tables = {}
    for kind in ("walks", "times"):
        path = folder / f"{kind}.parquet"
        if not path.exists():
            raise InputError(f"{path}: no such file; run a batch into this folder", path=path)
        tables[kind] = parquet.read_table(path).to_pylist()
    page = folder / "statistics.html"
    page.write_text(_page(tables["walks"], tables["times"]))
    return page


def _page(walks: list[dict[str, Any]], times: list[dict[str, Any]]) -> str:
    accepted = [row for row in walks if row["outcome"] == "accepted"]
    seconds = _column(times, "seconds")
    head = f"{len(walks)} walks, {len(accepted)} planned and accepted by the checker"
    parts = [
        "<!doctype html><html lang=en><meta charset=utf-8><title>Surefoot: walks</title>",
        f"<style>{STYLE}</style><h1>Walks</h1><p>{head}.</p>",
        _outcomes(walks),
        _by_scenario(accepted),
        "<h2>Distributions of the accepted walks</h2>",
        _histogram("steps", _column(accepted, "steps")),
        _histogram("duration, s", _column(accepted, "duration")),
        _histogram("work of the search, units", _column(accepted, "work")),
        _histogram("planning and checking, s", seconds),
        "<h2>Worst margins</h2>",
        *(_histogram(name, _column(accepted, f"margin_{name}")) for name in MARGINS),
    ]
    return "\n".join(part for part in parts if part) + "\n"


def _outcomes(walks: list[dict[str, Any]]) -> str:
    names = sorted({row["outcome"] for row in walks})
    groups = _grouped(walks)
    rows = [
        [name, *(sum(row["outcome"] == outcome for row in group) for outcome in names)]
        for name, group in groups
    ]
    return "<h2>Outcomes</h2>" + _table(["scenario, robot", *names], rows)


def _by_scenario(accepted: list[dict[str, Any]]) -> str:
    rows = []
    for name, group in _grouped(accepted):
        steps, work = _column(group, "steps"), _column(group, "work")
        balance = _column(group, "margin_balance")
        distinct = len({row["digest"] for row in group})
        rows.append(
            [
                name,
                len(group),
                distinct,
                f"{steps.mean():.1f}",
                f"{_column(group, 'duration').mean():.1f}",
                f"{np.median(work):.0f}",
                f"{np.percentile(work, 95):.0f}",
                f"{1e3 * balance.min():.1f}" if len(balance) else "-",
            ]
        )
    head = ["scenario, robot", "accepted", "distinct", "steps, mean", "duration, mean, s"]
    head += ["work, median", "work, p95", "balance, worst, mm"]
    return "<h2>Accepted walks</h2>" + _table(head, rows)


def _grouped(walks: list[dict[str, Any]]) -> list[tuple[str, list[dict[str, Any]]]]:
    groups: dict[str, list[dict[str, Any]]] = {}
    for row in walks:
        name = f"{row['scenario']}, {row['robot'] or 'its own'}"
        groups.setdefault(name, []).append(row)
    return sorted(groups.items())


def _column(rows: list[dict[str, Any]], name: str) -> NDArray[np.float64]:
    return np.array([row[name] for row in rows if row[name] is not None], dtype=np.float64)


def _table(head: Iterable[str], rows: Iterable[Iterable[object]]) -> str:
    def line(cells: Iterable[object], tag: str) -> str:
        return "".join(f"<{tag}>{html.escape(str(cell))}</{tag}>" for cell in cells)

    body = "".join(f"<tr>{line(row, 'td')}</tr>" for row in rows)
    return f"<table><tr>{line(head, 'th')}</tr>{body}</table>"


def _histogram(name: str, numbers: NDArray[np.float64]) -> str:
    if not len(numbers):
        return ""
    counts, edges = np.histogram(numbers, bins=BINS)
    wide, high = WIDTH / BINS, HEIGHT / max(1, counts.max())
    bars = "".join(
        f'<rect x="{at * wide:.1f}" y="{HEIGHT - count * high:.1f}" width="{wide - 1:.1f}" '
        f'height="{count * high:.1f}"/>'
        for at, count in enumerate(counts)
    )
    caption = f"{html.escape(name)}: {edges[0]:.4g} to {edges[-1]:.4g}, median "
    caption += f"{np.median(numbers):.4g}"
    picture = f'<svg width="{WIDTH}" height="{HEIGHT}" role="img">{bars}</svg>'
    return f"<figure>{picture}<figcaption>{caption}</figcaption></figure>"


if __name__ == "__main__":
    print(write_page(sys.argv[1] if len(sys.argv) > 1 else "."))
