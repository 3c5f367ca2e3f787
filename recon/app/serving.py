"""The server of the pages, by default for this machine only."""

import secrets
import socket
import webbrowser
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from recon.app.guard import Guard, is_loopback
from recon.errors import InputError
from recon.libraries import check_extra, load_extra, share_arenas

DEFAULT_PORT = 8600
NUM_TRIED = 20
"""Number of ports tried, starting at the default, if none is given."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Address:
    """The address of a page, and the socket that listens there."""

    host: str
    listener: socket.socket
    token: str | None

    @property
    def port(self) -> int:
        """The port of the socket."""
        return int(self.listener.getsockname()[1])

    @property
    def url(self) -> str:
        """The URL for a browser."""
        shown = {"0.0.0.0": socket.gethostname(), "::": socket.gethostname()}.get(
            self.host, f"[{self.host}]" if ":" in self.host else self.host
        )
        query = f"?token={self.token}" if self.token else ""
        return f"http://{shown}:{self.port}/{query}"


def listen(host: str, port: int | None) -> Address:
    """A socket for the page; by default on the first free port >= DEFAULT_PORT.

    Raises
    ------
    InputError
        If the host is not this machine's, or the port is taken.
    """
    wanted = [port] if port is not None else [*range(DEFAULT_PORT, DEFAULT_PORT + NUM_TRIED), 0]
    family = socket.AF_INET6 if ":" in host else socket.AF_INET
    fault: OSError | None = None
    for number in wanted:
        listener = socket.socket(family, socket.SOCK_STREAM)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            listener.bind((host, number))
            listener.listen(128)
        except (OSError, OverflowError) as error:
            listener.close()
            fault = error if isinstance(error, OSError) else OSError(0, str(error))
            continue
        token = None if is_loopback(host) else secrets.token_urlsafe(24)
        return Address(host=host, listener=listener, token=token)
    where = f"--host {host}" if port is None else f"--host {host} --port {port}"
    raise InputError(f"{where}: {fault.strerror if fault else 'in use'}; give another one")


def serve(
    build: Callable[[], None], address: Address, title: str, announce: Callable[[], Any]
) -> None:
    """Show a page until Ctrl-C.

    Parameters
    ----------
    build : callable
        Fills the page of one visitor.
    address : Address
    title : str
    announce : callable
        Called when the socket listens, before the server libraries are loaded.
    """
    # A browser takes a while to open; the socket already listens, and answers when loaded.
    check_extra("nicegui", "app")
    announce()
    share_arenas()
    nicegui = load_extra("nicegui", "app")
    fastapi = load_extra("fastapi", "app")
    uvicorn = load_extra("uvicorn", "app")
    inner = fastapi.FastAPI(docs_url=None, redoc_url=None, openapi_url=None)
    nicegui.ui.page("/", title=title)(build)
    nicegui.ui.run_with(
        inner, title=title, tailwind=False, storage_secret=secrets.token_urlsafe(32),
        reconnect_timeout=20.0,
        session_middleware_kwargs={"session_cookie": f"recon_session_{address.port}"},
    )  # fmt: skip
    guarded = Guard(inner, address.host, address.token, f"recon_token_{address.port}")
    config = uvicorn.Config(
        guarded, log_level="warning", access_log=False, lifespan="on", timeout_graceful_shutdown=2,
    )  # fmt: skip
    uvicorn.Server(config).run(sockets=[address.listener])


def open_browser(url: str) -> None:
    """Open the page in a browser, if there is one."""
    try:
        webbrowser.get()
    except webbrowser.Error:
        return
    webbrowser.open(url)
