"""``python -m endocal`` is the command ``endocal``."""

from .cli.entry import main

main()
