"""Many recordings in one go: which there are, what is done already, and the rest on many processes."""
