"""What the commands do, as functions: a spec in, a report out, no terminal."""
