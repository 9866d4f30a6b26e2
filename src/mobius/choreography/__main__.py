"""Build the shipped motions from their numbers, or search for better numbers.

python -m mobius.choreography                       # write modes/motions/data/*.json
python -m mobius.choreography roll --seconds 600    # search first, keep what is better
"""

from __future__ import annotations

import argparse
import json
import sys
from importlib import resources
from pathlib import Path

from mobius.choreography.designs import (
    DESIGNS,
    as_document,
    design_of,
    numbers_file,
    read_numbers,
)
from mobius.errors import MobiusError
from mobius.files import write_text_atomic


def build_all() -> list[Path]:
    """Write every motion that is built from numbers; returns the files."""
    folder = Path(str(resources.files("mobius.modes.motions") / "data"))
    written = []
    for design in DESIGNS.values():
        path = folder / f"{design.name}.json"
        document = as_document(design.build(read_numbers(design)))
        write_text_atomic(path, json.dumps(document) + "\n")
        written.append(path)
    return written


def improve(name: str, *, seconds: float, seeds: int, workers: int) -> None:
    """Search from the numbers there are and keep what is better."""
    from mobius.choreography.search import chosen, search

    design = design_of(name)
    if len(design.numbers) > 1:
        raise SystemExit(f"'{name}' shares all its numbers; search {', '.join(design.numbers)}")
    numbers, cost = search(
        name,
        read_numbers(design),
        seeds=range(seeds),
        seconds=seconds,
        workers=workers,
        progress=lambda g, best, now: print(f"{g:4d}  best {best:.4f}  now {now:.4f}", flush=True),
    )
    path = numbers_file(design.numbers[0])
    write_text_atomic(path, json.dumps(chosen(design, numbers), indent=1) + "\n")
    print(f"{path}: cost {cost:.4f}")


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("name", nargs="?", help="a design to search for first")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--workers", type=int, default=2)
    args = parser.parse_args()
    try:
        if args.name is not None:
            improve(args.name, seconds=args.seconds, seeds=args.seeds, workers=args.workers)
        for path in build_all():
            print(path)
    except MobiusError as error:
        print(f"error: {error}", file=sys.stderr)
        return 2
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
