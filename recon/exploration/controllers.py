"""Controllers by name: the built-in ones and plug-ins."""

import logging
from collections.abc import Callable
from typing import TYPE_CHECKING, Protocol

from recon.errors import InputError, check_finite
from recon.plugins import Registry
from recon.records import View

if TYPE_CHECKING:
    from recon.exploration.state import State

log = logging.getLogger(__name__)


class Controller(Protocol):
    """The part that guides the agent (thesis 4.3; its Appendix C calls it a camera controller).

    A new one is created, without arguments, for every exploration. It is asked once after every
    pair, except those that an agent with motion noise takes to localise itself, and again if its
    path would run into something, which `state.floor.touched` then contains.
    """

    def next_view(self, state: "State") -> View | None:
        """The next position and point to look at; None when it is done.

        The agent walks to a plain `View` in a straight line, to a `Walk` along its path.
        """
        ...

    def info(self) -> str:
        """Its strategy, in one line."""
        ...

    def result(self) -> str:
        """The result in words; a stop reason before the first ";" is that of the exploration."""
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
    """Create the controller with that name.

    Raises
    ------
    InputError
        For an unknown name, listing the known ones, or a plug-in that does not load or lacks a
        method.
    """
    factory = CONTROLLERS.load(name)
    try:
        made = factory()
    # A third-party package may fail in any way.
    except Exception as error:
        raise InputError(
            f"controller {name!r} cannot be made: {type(error).__name__}: {error}"
        ) from error
    check_controller(repr(name), made)
    return made


def check_controller(called: str, controller: object) -> None:
    """Raise `InputError` unless it has the methods of a controller."""
    lacking = [
        name for name in ("next_view", "info", "result")
        if not callable(getattr(controller, name, None))
    ]  # fmt: skip
    if lacking:
        raise InputError(
            f"controller {called} has no {' and no '.join(lacking)}, but an object with next_view, "
            "info and result is needed"
        )


def check_view(view: View) -> None:
    """Raise `InputError` unless a controller's answer is a view of finite numbers."""
    if not isinstance(view, View):
        raise InputError(f"next_view returned {view!r}, but a View or None is needed")
    for name, value in (("position", view.position), ("target", view.target)):
        check_finite(name, value)
    # Late: listing the names of controllers does not need it.
    from recon.exploration.state import Walk

    if isinstance(view, Walk):
        check_finite("via", view.via)


def result_of(controller: Controller) -> str:
    """A controller's result so far in words; empty if a plug-in fails to return it."""
    try:
        return str(controller.result())
    except Exception:
        log.debug("the controller has no result", exc_info=True)
        return ""
