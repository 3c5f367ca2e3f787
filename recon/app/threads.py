"""Background work of the page, in daemon threads."""

import asyncio
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import TypeVar

Made = TypeVar("Made")


async def in_thread(make: Callable[[], Made]) -> Made:
    """The result of `make`, or its error, from a separate thread; the page stays responsive."""
    loop = asyncio.get_running_loop()
    done: asyncio.Future[Made] = loop.create_future()

    def tell(result: Made | None, error: Exception | None) -> None:
        if done.cancelled():
            return
        if error is not None:
            done.set_exception(error)
        else:
            done.set_result(result)  # type: ignore[arg-type]

    def work() -> None:
        result, fault = None, None
        try:
            result = make()
        # Any error is raised again where the result is awaited.
        except Exception as error:
            fault = error
        # The loop is closed if the program has ended meanwhile.
        with suppress(RuntimeError):
            loop.call_soon_threadsafe(tell, result, fault)

    threading.Thread(target=work, daemon=True, name="recon page").start()
    return await done
