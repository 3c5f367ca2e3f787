"""Options of the commands that show a page, and the message with its address."""

import sys
from collections.abc import Callable
from typing import Any

import click

from recon.cli.output import print_document

SERVER: list[Any] = [
    click.option("--host", default="127.0.0.1", show_default=True,
                 help="Address to listen on; any but a loopback address requires a token."),
    click.option("--port", type=click.IntRange(0, 65535),
                 help="Port to listen on; default: the first free one from 8600."),
    click.option("--no-browser", is_flag=True, help="Only print the address."),
]  # fmt: skip


def announced(url: str, given: dict[str, Any]) -> Callable[[], None]:
    """Prints the address of a page, and opens it if there is a browser."""

    def announce() -> None:
        from recon.app.serving import open_browser

        print_document({**given, "quiet": False}, {"url": url}, [url])
        sys.stdout.flush()
        if not given["no_browser"]:
            open_browser(url)

    return announce
