"""Many walks at once, on Ray: scenarios x robots x seeds in, Parquet out.

    python -m surefoot.batch --out walks --scenarios flat_walk stairs --seeds 1-100 --workers 2

The folder can be resumed: walks that are done stay. ``walks.parquet`` depends on the inputs alone,
whatever the number of workers; ``times.parquet`` holds the times.
"""

from __future__ import annotations

import argparse
import itertools
import json
import logging
import os
import sys
import tempfile
import time
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from surefoot.errors import ClusterError, Error, ParameterError, missing
from surefoot.walks import MARGINS, Options, Task, walk

ATTEMPTS_MAX = 3
"""How often a walk is given to a worker before it is left out: workers may be killed."""
CALLS_PER_CPU = 3
"""Walks that wait or run for each core, so that no worker waits for the driver."""
PART_ROWS = 64
"""Rows of a part file: at most so many walks are lost if this process is killed."""
STORE_BYTES = 80 << 20
"""Shared memory of a local Ray: rows are small."""
KEY = ("scenario", "robot", "seed")


@dataclass(frozen=True)
class Summary:
    """How a batch ended."""

    out: Path
    """Its folder."""
    walks: int
    """Walks in ``walks.parquet``."""
    resumed: int
    """Those that were done before."""
    outcomes: dict[str, int]
    """How many ended how."""
    lost: list[Task]
    """Walks whose worker died each time; the next run tries them again."""


def run(
    scenarios: Iterable[str],
    seeds: Iterable[int],
    robots: Iterable[str] = ("",),
    *,
    out: str | os.PathLike[str],
    workers: int | None = None,
    address: str | None = None,
    work_max: int | None = None,
    threads: int = 1,
    plans: bool = False,
    progress: bool = True,
) -> Summary:
    """Plans and checks every combination. Results are in ``out``, a folder.

    ``robots`` are names or files that replace the scenario's robot; ``""`` keeps it. Ray runs on
    this machine with ``workers`` cores (all by default), or on the cluster at ``address``, whose
    machines need this package and all named files. ``plans`` keeps every plan as a file in
    ``out/plans``; if scenario or robot is a file, its name ends with a digest of their paths.
    Raises :class:`surefoot.ParameterError` if the folder holds another batch.
    """
    tasks = sorted(
        {Task(*one) for one in itertools.product(map(str, scenarios), robots, map(int, seeds))}
    )
    if not tasks:
        raise ParameterError("a batch needs a scenario, a robot and a seed")
    folder = Path(out).absolute()
    options = Options(threads, work_max, str(folder / "plans") if plans else "")
    store = _Store(folder, options)
    done = store.known()
    waiting = [task for task in tasks if task not in done]
    with _ray(workers, address) as ray:
        lost = _run_all(ray, waiting, options, store, _Progress(len(waiting), progress))
    return store.finish(tasks, len(tasks) - len(waiting), lost)


def _run_all(
    ray: Any, tasks: list[Task], options: Options, store: _Store, progress: _Progress
) -> list[Task]:
    """Gives all tasks to workers. A task whose worker dies is given out again."""
    remote = ray.remote(num_cpus=options.threads, max_retries=0)(walk)
    cpus = max(1, int(ray.cluster_resources().get("CPU", 1)))
    if not 1 <= options.threads <= cpus:
        message = f"threads is {options.threads}; Ray has {cpus} cores, and a walk needs as many"
        raise ParameterError(message, parameter="threads")
    waiting, attempts = deque(tasks), dict.fromkeys(tasks, 0)
    running: dict[Any, Task] = {}
    lost: list[Task] = []
    try:
        while waiting or running:
            while waiting and len(running) < CALLS_PER_CPU * cpus:
                task = waiting.popleft()
                attempts[task] += 1
                running[remote.remote(task, options)] = task
            (call,), _ = ray.wait(list(running), num_returns=1)
            task = running.pop(call)
            try:
                row, times = ray.get(call)
            except ray.exceptions.RayTaskError:
                raise  # A defect of ours, which would come again.
            except ray.exceptions.RayError:
                (waiting if attempts[task] < ATTEMPTS_MAX else lost).append(task)
                continue
            store.add(row, {**times, "attempts": attempts[task]})
            progress.add(row["outcome"])
    finally:
        store.flush()
        progress.end()
    return lost


@contextmanager
def _ray(workers: int | None, address: str | None) -> Iterator[Any]:
    """Ray on this machine, without its dashboard and its reports, or at an address."""
    os.environ.setdefault("RAY_USAGE_STATS_ENABLED", "0")
    if address is None:
        os.environ.setdefault("RAY_AUTH_MODE", "disabled")
    try:
        import ray
    except ImportError:
        raise missing("ray", "batch") from None
    if ray.is_initialized():
        yield ray
        return
    with tempfile.TemporaryDirectory(prefix="surefoot-ray-", ignore_cleanup_errors=True) as folder:
        try:
            if address is not None:
                ray.init(address=address, log_to_driver=False)
            else:
                _init_here(ray, workers or len(os.sched_getaffinity(0)), folder)
        except Exception as error:  # Ray has no one exception for it.
            where = address or "this machine"
            raise ClusterError(f"Ray cannot be started or reached at {where}: {error}") from error
        try:
            yield ray
        finally:
            ray.shutdown()


def _init_here(ray: Any, cpus: int, folder: str) -> None:
    ray.init(
        num_cpus=cpus,
        include_dashboard=False,
        object_store_memory=STORE_BYTES,
        log_to_driver=False,
        logging_level=logging.WARNING,
        _temp_dir=folder,
    )


class _Store:
    """The folder of a batch: part files while it runs, two tables at its end."""

    def __init__(self, folder: Path, options: Options) -> None:
        try:
            import pyarrow
            import pyarrow.parquet as parquet
        except ImportError:
            raise missing("pyarrow", "batch") from None
        self._arrow, self._parquet = pyarrow, parquet
        self.folder, self._parts = folder, folder / "parts"
        self._parts.mkdir(parents=True, exist_ok=True)
        if options.plans:
            Path(options.plans).mkdir(exist_ok=True)
        self._rows: list[dict[str, Any]] = []
        self._times: list[dict[str, Any]] = []
        self._check_options(options)

    def _check_options(self, options: Options) -> None:
        """Refuses to mix walks with other bounds."""
        path = self.folder / "batch.json"
        bounds = {"work_max": options.work_max}
        if path.exists():
            there = json.loads(path.read_text())
            if there != bounds:
                message = f"{self.folder} holds a batch with {there}, not {bounds}; choose another"
                raise ParameterError(message, parameter="out")
        _write(path, json.dumps(bounds).encode())

    def _schemas(self) -> dict[str, Any]:
        text, number, count = self._arrow.string(), self._arrow.float64(), self._arrow.int64()
        key = [("scenario", text), ("robot", text), ("seed", self._arrow.uint64())]
        walks = [
            *key,
            ("outcome", text),
            ("message", text),
            ("digest", text),
            *((name, count) for name in ("steps", "waypoints", "work", "sequences")),
            ("duration", number),
            ("root_path", number),
            *((f"margin_{name}", number) for name in MARGINS),
        ]
        times = [*key, ("seconds", number), ("process", count), ("attempts", count)]
        return {"walks": self._arrow.schema(walks), "times": self._arrow.schema(times)}

    def known(self) -> set[Task]:
        """The walks that part files hold."""
        return {Task(*(row[name] for name in KEY)) for row in self._read("walks")}

    def add(self, row: dict[str, Any], times: dict[str, Any]) -> None:
        """Keeps a finished walk."""
        self._rows.append(row)
        self._times.append(times)
        if len(self._rows) >= PART_ROWS:
            self.flush()

    def flush(self) -> None:
        """Writes the walks that were kept since the last time; times first, since the walks are
        what says that a part is complete."""
        if not self._rows:
            return
        name = f"{time.time_ns()}-{os.getpid()}"
        self._write_table(self._times, "times", self._parts / f"{name}.times.parquet")
        self._write_table(self._rows, "walks", self._parts / f"{name}.walks.parquet")
        self._rows, self._times = [], []

    def finish(self, tasks: Sequence[Task], resumed: int, lost: list[Task]) -> Summary:
        """Writes the tables of all walks that were asked for, each once and in order."""
        wanted = set(tasks)
        tables = {}
        for kind in ("walks", "times"):
            by_task = {Task(*(row[name] for name in KEY)): row for row in self._read(kind)}
            tables[kind] = [by_task[task] for task in sorted(wanted & by_task.keys())]
            self._write_table(tables[kind], kind, self.folder / f"{kind}.parquet")
        outcomes: dict[str, int] = {}
        for row in tables["walks"]:
            outcomes[row["outcome"]] = outcomes.get(row["outcome"], 0) + 1
        ordered = dict(sorted(outcomes.items()))
        return Summary(self.folder, len(tables["walks"]), resumed, ordered, lost)

    def _read(self, kind: str) -> list[dict[str, Any]]:
        rows: list[dict[str, Any]] = []
        for path in sorted(self._parts.glob(f"*.{kind}.parquet")):
            rows.extend(self._parquet.read_table(path).to_pylist())
        return rows

    def _write_table(self, rows: list[dict[str, Any]], kind: str, path: Path) -> None:
        table = self._arrow.Table.from_pylist(rows, schema=self._schemas()[kind])
        sink = self._arrow.BufferOutputStream()
        self._parquet.write_table(table, sink)
        _write(path, sink.getvalue().to_pybytes())


def _write(path: Path, content: bytes) -> None:
    """Writes a file completely or not at all."""
    temporary = path.with_name(f".{path.name}.{os.getpid()}")
    temporary.write_bytes(content)
    temporary.replace(path)


class _Progress:
    """One line on the standard error that says how far a batch is."""

    def __init__(self, count: int, is_shown: bool) -> None:
        self._count, self._done, self._accepted = count, 0, 0
        self._begin = time.monotonic()
        self._is_shown = is_shown
        self._is_terminal = sys.stderr.isatty()

    def add(self, outcome: str) -> None:
        """Counts a walk."""
        self._done += 1
        self._accepted += outcome == "accepted"
        step = max(1, self._count // (200 if self._is_terminal else 10))
        if self._is_shown and (self._done % step == 0 or self._done == self._count):
            rate = self._done / max(1e-9, time.monotonic() - self._begin)
            left = (self._count - self._done) / rate
            text = (
                f"{self._done} of {self._count} walks, {self._accepted} accepted, "
                f"{rate:.1f}/s, {left:.0f} s left"
            )
            end = "\r" if self._is_terminal else "\n"
            print(f"{text:<72}", end=end, file=sys.stderr, flush=True)

    def end(self) -> None:
        """Leaves the line."""
        if self._is_shown and self._is_terminal and self._done:
            print(file=sys.stderr)


def _seeds(text: str) -> list[int]:
    """Seeds from 1-100 or 1,5,9."""
    seeds: list[int] = []
    for part in text.split(","):
        first, _, last = part.partition("-")
        seeds.extend(range(int(first), int(last or first) + 1))
    return seeds


def main(arguments: list[str] | None = None) -> int:
    """The command: exit code 0 if every walk has a result, 2 for inputs that cannot be used, 4 if
    workers died too often."""
    parser = argparse.ArgumentParser(
        prog="python -m surefoot.batch", description=(__doc__ or "").splitlines()[0]
    )
    parser.add_argument("--out", required=True, metavar="DIR", help="new, or one to resume")
    parser.add_argument("--scenarios", nargs="+", required=True, metavar="SCENARIO")
    parser.add_argument("--seeds", type=_seeds, default=[1], metavar="1-100", help="also 1,5,9")
    parser.add_argument("--robots", nargs="+", default=[""], metavar="ROBOT")
    parser.add_argument("--workers", type=int, metavar="N", help="cores of this machine (all)")
    parser.add_argument("--address", metavar="HOST:PORT", help="of a Ray cluster")
    parser.add_argument("--work-max", type=int, metavar="UNITS", help="limit of each search")
    parser.add_argument("--plans", action="store_true", help="keep every plan as a file")
    parser.add_argument("--statistics", action="store_true", help="write statistics.html too")
    options = parser.parse_args(arguments)
    try:
        summary = run(
            options.scenarios,
            options.seeds,
            options.robots,
            out=options.out,
            workers=options.workers,
            address=options.address,
            work_max=options.work_max,
            plans=options.plans,
        )
        if options.statistics:
            from surefoot.statistics import write_page

            write_page(summary.out)
    except (Error, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    print(json.dumps({**asdict(summary), "out": str(summary.out)}))
    return 4 if summary.lost else 0


if __name__ == "__main__":
    sys.exit(main())
