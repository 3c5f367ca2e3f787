"""Recognition: from occupied cells to named objects."""

from recon.recognition.recognition import components, recognise

__all__ = ["components", "recognise"]
