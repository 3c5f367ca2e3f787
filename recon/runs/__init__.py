"""Complete runs: stages, run folder and figures together; the common core of all interfaces."""
