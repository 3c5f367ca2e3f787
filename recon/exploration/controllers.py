"""Controllers by name: those that lead the agent, and the plug-ins beside them."""

import logging
from collections.abc import Callable
from typing import Protocol

from recon.errors import InputError, check_finite
from recon.exploration.state import State, Walk
from recon.plugins import Registry
from recon.records import View

log = logging.getLogger(__name__)


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
        """The result in words; a stop reason before a ";" at its beginning is the exploration's."""
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


def check_view(view: View) -> None:
    """Raise `InputError` unless a controller's answer is a view of finite numbers."""
    if not isinstance(view, View):
        raise InputError(f"next_view gave {view!r}, but a View or None is needed")
    for name, value in (("position", view.position), ("target", view.target)):
        check_finite(name, value)
    if isinstance(view, Walk):
        check_finite("via", view.via)


def result_of(controller: Controller) -> str:
    """A controller's own words on its result so far; none of a plug-in that fails to say any."""
    try:
        return str(controller.result())
    except Exception:
        log.debug("the controller has no result", exc_info=True)
        return ""
