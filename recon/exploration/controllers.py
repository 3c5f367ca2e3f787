"""Who tells the agent where to go: the controllers by name, and the plug-ins beside them."""

import difflib
from collections.abc import Callable
from importlib.metadata import EntryPoint, entry_points
from typing import Protocol

from recon.errors import InputError
from recon.exploration.frontier import FrontierController
from recon.exploration.state import State
from recon.exploration.thesis import ThesisController
from recon.records import View

GROUP = "recon.controllers"
"""Entry-point group in which installed packages offer controllers."""


class Controller(Protocol):
    """Leads the agent (thesis 4.3; its Appendix C calls it a camera controller).

    It is made anew, without arguments, for every exploration, and asked once after every pair.
    """

    def next_view(self, state: State) -> View | None:
        """Where to stand and look next; None when it is done.

        A plain `View` is walked to in a straight line, a `Walk` by its own way.
        """
        ...

    def info(self) -> str:
        """Who it is and what it does, in a line."""
        ...

    def result(self) -> str:
        """What came of it; a stop reason at its beginning, before a ";", is the exploration's."""
        ...


CONTROLLERS: dict[str, Callable[[], Controller]] = {
    "frontier": FrontierController,
    "thesis": ThesisController,
}


def make_controller(name: str) -> Controller:
    """The controller of that name, out of the table or an installed package.

    Raises
    ------
    InputError
        For a name nobody knows, with the known ones, and for a plug-in that does not load.
    """
    if name in CONTROLLERS:
        return CONTROLLERS[name]()
    plugins = entry_points(group=GROUP)
    if name in plugins.names:
        return _plugged_in(plugins[name])
    known = sorted({*CONTROLLERS, *plugins.names})
    near = difflib.get_close_matches(name, known, n=1, cutoff=0.0)
    raise InputError(
        f"exploration.controller is {name!r}, but one of {', '.join(known)} is needed "
        f"(nearest: {near[0]})"
    )


def _plugged_in(plugin: EntryPoint) -> Controller:
    try:
        made: Controller = plugin.load()()
    # A package of somebody else's may fail in any way.
    except Exception as error:
        raise InputError(
            f"controller {plugin.name!r} ({plugin.value}) does not load: "
            f"{type(error).__name__}: {error}"
        ) from error
    return made
