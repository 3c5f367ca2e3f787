"""Feed a reader mutations of a sound file: python tools/fuzz.py READER -n N [--seed S].

READER is an ending or a kind of document, or `all`; what fails is kept in the folder `fuzz/` and
named with its seed. Memory is bounded at 6 GB.
"""

import argparse
import resource
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[1]))

from tests.fuzzing import Reader, fault, mutated, readers

MEMORY = 6 << 30


def main() -> int:
    """Fuzz, print a line a reader, and return 1 where anything failed."""
    with tempfile.TemporaryDirectory() as folder:
        found = readers(Path(folder))
        parser = argparse.ArgumentParser(description=__doc__)
        parser.add_argument("reader", choices=["all", *found])
        parser.add_argument("-n", type=int, default=1000, help="mutations a reader")
        parser.add_argument("--seed", type=int, default=0)
        given = parser.parse_args()
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        chosen = found.values() if given.reader == "all" else [found[given.reader]]
        return int(sum(fuzz(one, given.n, given.seed, Path(folder)) for one in chosen) > 0)


def fuzz(reader: Reader, num: int, seed: int, folder: Path) -> int:
    """How many of the mutations a reader takes badly; those are kept."""
    began = time.perf_counter()
    num_faults = 0
    for number in range(num):
        content = mutated(reader.content, np.random.default_rng([seed, number]))
        wrong = fault(reader, content, folder)
        if wrong:
            num_faults += 1
            kept = Path("fuzz") / f"{seed}-{number}{reader.name}"
            kept.parent.mkdir(exist_ok=True)
            kept.write_bytes(content)
            print(f"{kept}: {wrong}")
    seconds = time.perf_counter() - began
    print(f"{reader.name:16} {num} mutations, {num_faults} faults, {seconds:.1f} s", flush=True)
    return num_faults


if __name__ == "__main__":
    sys.exit(main())
