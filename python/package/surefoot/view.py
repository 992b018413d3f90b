"""Shows a saved plan in Rerun: ``python -m surefoot.view PLAN.json [--save WALK.rrd]``."""

from __future__ import annotations

import argparse
import sys
from types import ModuleType
from typing import Any

from surefoot.errors import Error
from surefoot.plans import Plan
from surefoot.viewer import RATE_HZ, view


class _Callable(ModuleType):
    """The module itself shows a plan too, since it hides the function of its name."""

    def __call__(self, *arguments: Any, **options: Any) -> Any:
        return view(*arguments, **options)


sys.modules[__name__].__class__ = _Callable


def main(arguments: list[str] | None = None) -> int:
    """The command; its exit code is 2 where an input cannot be used."""
    parser = argparse.ArgumentParser(prog="python -m surefoot.view", description=__doc__)
    parser.add_argument("plan", help="a plan that was saved with --export or Plan.save")
    parser.add_argument("--save", metavar="WALK.rrd", help="write a file, start no viewer")
    parser.add_argument("--connect", metavar="URL", help="send to a viewer that runs")
    parser.add_argument(
        "--rate", type=float, default=RATE_HZ, metavar="HZ", help=f"frames per second ({RATE_HZ:g})"
    )
    options = parser.parse_args(arguments)
    try:
        shown = view(
            Plan.load(options.plan),
            save=options.save,
            connect=options.connect,
            rate_hz=options.rate,
        )
    except (Error, OSError) as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    if shown.path is not None:
        print(f"wrote {shown.path}: {shown.seconds:.1f} s; open it with: rerun {shown.path}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
