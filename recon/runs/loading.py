"""The first pair of a recording, read while the loops that match it are loaded."""

from concurrent.futures import ThreadPoolExecutor
from contextvars import copy_context

import numpy as np

from recon.mapping.sparse import match_sparse
from recon.records import PairSource, StereoPair
from recon.settings import Settings
from recon.threads import alone

_SIZE = (64, 96)
_SHIFT_PX = 4


def first_pair(source: PairSource, settings: Settings) -> StereoPair:
    """The first pair of a source, read in a thread.

    Meanwhile, this one matches two small images, which need nearly all compiled loops of the
    settings: reading, and tracking what tells the residual rows, mostly run beside Python.
    """
    with ThreadPoolExecutor(1) as reader:
        first = reader.submit(copy_context().run, next, iter(source))
        image = np.random.default_rng(0).integers(0, 256, _SIZE, np.uint8)
        alone(match_sparse)(image, np.roll(image, -_SHIFT_PX, axis=1), settings)
        return first.result()
