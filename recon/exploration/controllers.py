"""Controllers by name: those that lead the agent, and the plug-ins beside them."""

from collections.abc import Callable
from typing import Protocol

from recon.errors import InputError
from recon.exploration.state import State
from recon.plugins import Registry
from recon.records import View


class Controller(Protocol):
    """The part that leads the agent (thesis 4.3; its Appendix C calls it a camera controller).

    It is made anew, without arguments, for every exploration, and asked once after every pair; and
    again where its way would run into something, which `state.floor.touched` holds from then on.
    """

    def next_view(self, state: State) -> View | None:
        """The next place to stand and point to look at; None when it is done.

        A plain `View` is walked to in a straight line, a `Walk` by its own path.
        """
        ...

    def info(self) -> str:
        """Its strategy, in a line."""
        ...

    def result(self) -> str:
        """What came of it; a stop reason at its beginning, before a ";", is the exploration's."""
        ...


CONTROLLERS: Registry[Callable[[], Controller]] = Registry(
    "recon.controllers",
    "controller",
    {
        "frontier": "recon.exploration.frontier:FrontierController",
        "thesis": "recon.exploration.thesis:ThesisController",
    },
)


def make_controller(name: str) -> Controller:
    """Make the controller of that name.

    Raises
    ------
    InputError
        For an unknown name, with the known ones, and for a plug-in that does not load.
    """
    factory = CONTROLLERS.load(name)
    try:
        return factory()
    # A package of somebody else's may fail in any way.
    except Exception as error:
        raise InputError(
            f"controller {name!r} cannot be made: {type(error).__name__}: {error}"
        ) from error
