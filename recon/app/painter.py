"""Drawing in the background: in a thread, only the latest request."""

import asyncio
import logging
import threading
from collections.abc import Callable
from contextlib import suppress
from typing import Any, Generic, TypeVar

from recon.app.threads import in_thread
from recon.app.widgets import nicegui
from recon.errors import ReconError
from recon.libraries import listening_to_compiler, load_extra

log = logging.getLogger(__name__)

Drawn = TypeVar("Drawn")

COMPILING = "compiling what draws; that is done once and takes about a minute"


class Painter(Generic[Drawn]):
    """Redraws on request; requests during drawing are merged into one redraw at the end.

    To be made while its page is built.

    Parameters
    ----------
    draw : callable
        Runs in a thread.
    show : callable
        Called with the result, in the page's own thread.
    complain : callable
        Called with the text of an error; the previous drawing stays.
    """

    def __init__(
        self,
        draw: Callable[[], Drawn],
        show: Callable[[Drawn], Any],
        complain: Callable[[str], Any],
    ) -> None:
        self.draw = draw
        self.show = show
        self.complain = complain
        self._is_wanted = False
        self._is_at_work = False
        self._client = nicegui().context.client
        self._notification: Any = None

    def ask(self) -> None:
        """Request a redraw."""
        self._is_wanted = True
        if not self._is_at_work:
            self._is_at_work = True
            load_extra("nicegui", "app").background_tasks.create(self._paint())

    async def _paint(self) -> None:
        try:
            while self._is_wanted:
                self._is_wanted = False
                await self._paint_once()
        finally:
            self._is_at_work = False

    async def _paint_once(self) -> None:
        loop = asyncio.get_running_loop()

        def draw() -> Drawn:
            own = threading.get_ident()

            def compiles() -> None:
                # Other threads may compile meanwhile, such as an exploration.
                if threading.get_ident() == own:
                    _tell(loop, self._notify)

            with listening_to_compiler(compiles, _done):
                return self.draw()

        try:
            drawn = await in_thread(draw)
        except (ReconError, OSError) as error:
            self.complain(str(error))
        # A plug-in or a damaged file may raise anything; the page stays.
        except Exception as error:
            log.exception("drawing failed")
            self.complain(f"{type(error).__name__}: {error}")
        else:
            self.show(drawn)
        finally:
            self._dismiss()

    def _notify(self) -> None:
        if self._notification is None:
            with self._client:
                self._notification = nicegui().notification(
                    COMPILING,
                    position="bottom-left",
                    spinner=True,
                    timeout=None,
                    classes="recon-wait",
                )

    def _dismiss(self) -> None:
        if self._notification is not None:
            self._notification.dismiss()
            self._notification = None


def _tell(loop: asyncio.AbstractEventLoop, what: Callable[[], None]) -> None:
    """Call something in the page's own thread, if the page still exists."""
    with suppress(RuntimeError):
        loop.call_soon_threadsafe(what)


def _done() -> None:
    """Do nothing: the notification goes when everything is drawn."""
