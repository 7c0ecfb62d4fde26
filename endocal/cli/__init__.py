"""The command line: options to spec, one call, print."""
