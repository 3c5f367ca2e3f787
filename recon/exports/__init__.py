"""Maps and clouds as files of other programs, and back."""

from recon.exports.formats import FORMATS, format_of, read, write

__all__ = ["FORMATS", "format_of", "read", "write"]
