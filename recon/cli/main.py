"""The program: a group of commands, and the reporting of their errors."""

from collections.abc import Sequence

import click

import recon
from recon.cli.batch import batch
from recon.cli.calibrate import calibrate
from recon.cli.catalogue import catalogue
from recon.cli.demo import demo
from recon.cli.disparity import disparity
from recon.cli.doctor import doctor
from recon.cli.ending import end
from recon.cli.evaluate import evaluate
from recon.cli.explore import explore
from recon.cli.export import export
from recon.cli.fetch import fetch
from recon.cli.figure import figure
from recon.cli.fit import fit
from recon.cli.info import info
from recon.cli.inspect import inspect
from recon.cli.interrupts import ending_as_ctrl_c
from recon.cli.learn import learn
from recon.cli.localise import localise
from recon.cli.merge import merge
from recon.cli.mesh import mesh
from recon.cli.output import stop_logging
from recon.cli.recognise import recognise
from recon.cli.reconstruct import reconstruct
from recon.cli.rectify import rectify
from recon.cli.render import render
from recon.cli.settings import settings
from recon.cli.simulate import simulate
from recon.cli.train import train
from recon.errors import InputError, ReconError
from recon.processes import collect_rarely

DONE, FAILED, WRONG_USE, INTERRUPTED = 0, 1, 2, 130


@click.group(
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Example: recon explore village",
)
@click.version_option(recon.__version__, prog_name="recon")
def program() -> None:
    """Reconstruct objects from stereo sequences."""


for command in (
    explore, reconstruct, merge, mesh, render, disparity, evaluate, train, calibrate, rectify,
    recognise, localise, learn, catalogue, fit, figure, export, info, inspect,
    simulate, doctor, batch, settings, demo, fetch,
):  # fmt: skip
    program.add_command(command)


def main(argv: Sequence[str] | None = None, *, is_alone: bool = False) -> int:
    """Run one command and return its exit code; a known error is one line on stderr.

    Parameters
    ----------
    argv : sequence of str, optional
        By default those of the process.
    is_alone : bool
        The process serves the command only, which may then start others.
    """
    try:
        with ending_as_ctrl_c():
            code = program.main(args=argv, prog_name="recon", standalone_mode=False, obj=is_alone)
    except click.exceptions.NoArgsIsHelpError as error:
        click.echo(error.format_message(), err=True)
        return WRONG_USE
    except click.ClickException as error:
        return _say(error.format_message(), WRONG_USE)
    except (click.Abort, KeyboardInterrupt):
        return _say("interrupted", INTERRUPTED)
    except InputError as error:
        return _say(str(error), WRONG_USE)
    except ReconError as error:
        return _say(str(error), FAILED)
    except OSError as error:
        return _say(f"{error.filename or 'standard output'}: {error.strerror or error}", WRONG_USE)
    finally:
        stop_logging()
    return code if isinstance(code, int) else DONE


def _say(message: str, code: int) -> int:
    line = " ".join(message.split())
    click.echo(f"recon: {line}", err=True)
    return code


def entry() -> None:
    """The console script."""
    collect_rarely()
    end(main(is_alone=True))
