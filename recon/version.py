"""The version of the installed distribution, which the build takes from the last tag."""

from importlib.metadata import PackageNotFoundError, version

try:
    __version__ = version("recon-stereo")
except PackageNotFoundError:  # sources that are not installed
    __version__ = "0+unknown"
