"""A sample of every kind of part that a package may add to recon; each file is one kind."""
