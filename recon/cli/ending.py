"""The end of the program, which takes nothing apart: the system frees it faster.

Functions registered for the end of a process run in reverse order. That of this module is
registered before all others, so that they have run when it ends the process.
"""

import atexit
import os
import sys
from typing import NoReturn

_codes: list[int] = []


def end(code: int) -> NoReturn:
    """End this process after everything registered for its end since recon was loaded.

    If its output cannot be written, it ends as usual, which says so.
    """
    _codes[:] = [code]
    sys.exit(code)


@atexit.register
def _leave() -> None:
    if not _codes:
        return
    try:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
    except (AttributeError, OSError, ValueError):
        return
    os._exit(_codes[0])
