"""Recognition: from occupied cells, or any cloud, to named objects."""

from recon.recognition.clouds import recognise_cloud
from recon.recognition.recognition import components, recognise

__all__ = ["components", "recognise", "recognise_cloud"]
